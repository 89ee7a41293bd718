#include "scan/job/brick_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "acquire/lidar/sweep_source.h"
#include "core/files/part_folder.h"
#include "fusion/bricks/brick_volume.h"
#include "scan/bricks/bricks_check.h"
#include "scan/bricks/fuse_parts.h"
#include "scan/bricks/join_parts.h"
#include "scan/bricks/plan_parts.h"
#include "scan/checks/memory_share.h"
#include "scan/checks/settings_check.h"
#include "scan/find_poses.h"
#include "scan/frames/posed_frames.h"
#include "scan/frames/recorded_frames.h"
#include "scan/job/brick_claim.h"
#include "scan/job/job_folder.h"
#include "scan/job/open_job.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

Result<void> check_is_new(const fs::path& folder) {
  std::error_code code;
  if (!fs::exists(folder, code) || (fs::is_directory(folder, code) && fs::is_empty(folder, code))) return {};
  return Error{ErrorCode::kOutput, "exists, and is not empty; choose another folder for the job", folder.string()};
}

Result<void> check_can_be_planned(const ScanJob& job) {
  const bool has_depth = job.config.acquire.geometry != Geometry::kSilhouettes && !job.meshes_each_class &&
                         !is_sweep_recording(job.input, job.config.acquire);
  if (has_depth) return {};
  return Error{ErrorCode::kUsage,
               "sweeps, silhouettes and classes are not scanned in bricks; scanknit run makes a mesh of them",
               job.input.string()};
}

/// Where a recording is, from the job's folder; empty if it cannot be said.
std::string near_place(const fs::path& recording, const fs::path& folder) {
  std::error_code code;
  const fs::path near = fs::relative(fs::absolute(recording, code), fs::absolute(folder, code), code);
  return code ? std::string() : near.string();
}

/// check_bricks(), for a person who asked for nothing else. Poses are known, at the latest when the job is planned.
Result<void> check_fits_bricks(const ScanJob& job) {
  const Result<void> possible = check_bricks(job, PoseMode::kRecording);
  if (possible) return {};
  return Error{ErrorCode::kUsage, possible.error().message + "; scanknit run fuses it in one process",
               job.input.string()};
}

JobHeader header_of(const ScanJob& job, const fs::path& folder, std::vector<ScanWarning> warnings) {
  std::error_code code;
  JobHeader header;
  header.near_recording = near_place(job.input, folder);
  header.far_recording = fs::absolute(job.input, code).lexically_normal().string();
  header.from = job.config.acquire.from;
  header.to = job.config.acquire.to;
  header.every = job.config.acquire.every;
  header.warnings = std::move(warnings);
  return header;
}

/// What a plan is made of: the poses of `request`, or those that are found.
struct Planned {
  PlannedScan scan;
  std::vector<ScanWarning> warnings;
};

/// Reads poses that the recording, or the request's file, has. `job` becomes complete.
Result<Planned> plan_known(const PlanRequest& request, ScanJob& job, ScanSession& session) {
  const PoseMode asked = job.config.acquire.poses;
  if (request.trajectory) job.config.acquire.poses = PoseMode::kStill;  // whatever the recording's
  auto opened = open_first(job, session);
  if (!opened) return opened.error();
  std::unique_ptr<FrameSource> source = std::move(opened->source);
  PoseOrigin origin = PoseOrigin::kRecording;
  if (request.trajectory) {
    auto poses = TrajectoryFile::read(*request.trajectory, job.config.acquire.limits);
    if (!poses) return poses.error();
    const auto count = poses->count_by_place();
    if (count && *count != source->info().frames) {
      return Error{ErrorCode::kInput,
                   fmt::format("has {} poses, and the recording {} frames; a trajectory without stamps has a line for "
                               "each frame",
                               *count, source->info().frames),
                   request.trajectory->string()};
    }
    source = std::make_unique<PosedFrames>(std::move(source), *std::move(poses), job.config.acquire.from,
                                           job.config.acquire.every);
    origin = PoseOrigin::kPlan;
  }
  job.config.acquire.poses = asked;
  if (auto told = session.observer().on_open(source->info()); !told) return told.error();
  const FrameArchive archive = archive_of(job);
  FrameCounts counts;
  auto planned = plan_parts(job, {.source = *source, .archive = archive, .stop = session.stop()}, origin, session,
                            counts, nullptr);
  if (!planned) return planned.error();
  return Planned{*std::move(planned), session.warnings()};
}

/// Tracks the recording. `job` becomes complete.
Result<Planned> plan_tracked(ScanJob& job, UpAxis world_up, ScanSession& session) {
  FoundPoses found = find_poses(job, session.observer(), session.stop());
  if (!found.scan.outcome) return found.scan.outcome.error();
  if (session.is_stopped()) return Error{ErrorCode::kInput, "interrupted before the poses were known"};
  job.config = found.scan.config;
  auto planned = plan_parts(job, found, world_up, session);
  if (!planned) return planned.error();
  return Planned{*std::move(planned), std::move(found.scan.warnings)};
}

/// The properties of the job's recording, nothing told to anyone.
Result<RecordingInfo> recording_info(ScanJob job) {
  ScanObserver silent;
  ScanSession session(silent, {});
  const auto opened = open_first(job, session);
  return opened ? Result<RecordingInfo>(opened->source->info()) : opened.error();
}

class Worker {
 public:
  Worker(const OpenJob& job, ScanSession& session) : job_(job), session_(session) {}

  /// `workers`: about so many share the job; 0: unknown.
  [[nodiscard]] Result<JobWork> all(std::size_t workers) {
    const std::size_t count = job_.folder.bricks();
    const std::vector<std::size_t> files = job_.folder.with_file();
    for (std::size_t i = 0; i < count; ++i) {
      if (std::binary_search(files.begin(), files.end(), i) && job_.folder.is_done(i)) continue;
      left_.insert(left_.end(), i);
      work_left_ += work_of(job_.planned.parts[i]);
    }
    while (!left_.empty() && !session_.is_stopped()) {
      const auto share = take_share(workers == 0 ? 0 : work_left_ / static_cast<double>(workers));
      if (!share) return share.error();
      if (auto fused = fuse(*share); !fused) return fused.error();
      session_.progress("fusing bricks", count - left_.size(), count);
    }
    work_.is_stopped = session_.is_stopped();
    return work_;
  }

  [[nodiscard]] Result<JobWork> one(std::size_t number) {
    const auto file = BrickFile::open(job_.folder.brick(number), job_.folder.id());
    std::error_code code;
    if (file && !file->is_whole()) fs::remove(job_.folder.brick(number), code);
    if (!file || !file->is_whole()) {
      Share share;
      if (auto added = add(number, share); !added) return added.error();
      if (auto fused = fuse(share); !fused) return fused.error();
    }
    work_.is_stopped = session_.is_stopped();
    return work_;
  }

 private:
  /// Bricks that no other worker is at.
  struct Share {
    PartGroup group;
    std::vector<std::unique_ptr<BrickClaim>> claims;
    std::size_t bytes = 0;   ///< of memory that the bricks may need
    std::size_t number = 0;  ///< WorkPlace::share_of()
  };

  /// Claims bricks with so much work, one at least, as far as the memory allows: neighbours, which have frames in
  /// common. Those that are done or that others are at are not looked at again.
  [[nodiscard]] Result<Share> take_share(double most_work) {
    Share share;
    WorkPlace place(most_work);
    auto next = left_.begin();
    while (next != left_.end() && fits(share, *next, place)) {
      const std::size_t number = *next;
      share.number = place.share_of(job_.planned.parts[number]);
      next = left_.erase(next);
      place.pass(job_.planned.parts[number]);
      work_left_ -= work_of(job_.planned.parts[number]);
      const auto is_others = add(number, share);
      if (!is_others) return is_others.error();
      // Whoever is at the first one is about to claim a share, too: this worker begins behind it.
      while (*is_others && share.group.empty() && next != left_.end() &&
             place.share_of(job_.planned.parts[*next]) == share.number) {
        place.pass(job_.planned.parts[*next++]);
      }
      if (next != left_.end() || !share.group.empty()) continue;
      next = left_.begin();
      place = WorkPlace(most_work);
    }
    return share;
  }

  [[nodiscard]] bool fits(const Share& share, std::size_t number, const WorkPlace& place) const {
    const std::size_t max_bytes = volume_budget_mib(job_.planned.fusion.memory_budget_mib) << 20;
    const BrickPart& part = job_.planned.parts[number];
    return share.group.empty() || (place.share_of(part) == share.number && share.bytes + part.most_bytes <= max_bytes);
  }

  /// Claims the brick, unless it is done, or another worker is at it: true then.
  [[nodiscard]] Result<bool> add(std::size_t number, Share& share) {
    if (job_.folder.is_done(number)) return false;  // since it was looked for
    auto claim = BrickClaim::take(job_.folder.claim(number));
    if (!claim) return claim.error();
    if (*claim == nullptr) {
      ++work_.elsewhere;
      return true;
    }
    if (job_.folder.is_done(number)) return false;
    share.claims.push_back(*std::move(claim));
    share.group.push_back(number);
    share.bytes += job_.planned.parts[number].most_bytes;
    return false;
  }

  [[nodiscard]] Result<void> fuse(const Share& share) {
    if (share.group.empty()) return {};
    const auto path_of = [&](std::size_t number) { return job_.folder.brick(number); };
    const auto fused = fuse_parts(job_.job, job_.planned, share.group, job_.folder.id(), path_of, session_);
    if (!fused) return fused.error();
    if (*fused) work_.fused += share.group.size();
    return {};
  }

  const OpenJob& job_;
  ScanSession& session_;
  JobWork work_;
  std::set<std::size_t> left_;  ///< bricks that this worker has not looked at
  double work_left_ = 0;        ///< of them
};

JobStatus status_of(const JobFolder& folder, BrickCheck check) {
  JobStatus status;
  status.recording = folder.recording().string();
  status.bricks = folder.bricks();
  const std::vector<std::size_t> files = folder.with_file();
  std::set<std::size_t> torn;
  for (const std::size_t number : files) {
    if (check == BrickCheck::kEnds && !folder.is_done(number)) torn.insert(number);
  }
  status.done = files.size() - torn.size();
  status.torn = torn.size();
  for (const std::size_t number : folder.with_claim()) {
    const bool is_left = !std::binary_search(files.begin(), files.end(), number) || torn.contains(number);
    if (!is_left) continue;
    const auto is_taken = BrickClaim::is_taken(folder.claim(number));
    if (is_taken && !*is_taken) continue;  // where nothing can be written, who knows
    ++status.in_work;
    status.torn -= torn.contains(number) ? 1 : 0;
  }
  status.free = status.bricks - status.done - status.in_work;
  return status;
}

Result<BrickVolume> all_bricks(const OpenJob& job, const fs::path& folder) {
  const JobStatus status = status_of(job.folder, BrickCheck::kEnds);
  if (status.done < status.bricks) {
    return Error{ErrorCode::kInput,
                 fmt::format("{} of {} bricks are missing ({} in work, {} torn): scanknit work {} makes them",
                             status.bricks - status.done, status.bricks, status.in_work, status.torn, folder.string()),
                 folder.string()};
  }
  BrickVolume bricks(job.job.config.fusion);
  for (std::size_t i = 0; i < status.bricks; ++i) {
    if (auto added = bricks.add(job.folder.brick(i), job.folder.id()); !added) return added.error();
  }
  return bricks;
}

/// Says which command mends a damaged brick.
Error with_remedy(Error error, const fs::path& folder) {
  const fs::path file = error.where;
  if (file.extension() != ".brick") return error;
  error.message +=
      fmt::format(", or only this brick: scanknit work {} --brick {}", folder.string(), file.stem().string());
  return error;
}

Result<void> join(OpenJob& job, const fs::path& folder, ScanSession& session, ScanResult& result) {
  warn_of_settings(job.job, session);
  for (const ScanWarning& warning : job.folder.header().warnings) session.warn(warning.code, warning.text);
  result.frames = job.planned.counts;
  result.trajectory = job.planned.recorded_order();
  result.tracking = job.planned.tracked.tracking;
  result.loops = job.planned.tracked.loops;
  const auto bricks = all_bricks(job, folder);
  if (!bricks) return bricks.error();
  if (auto written = write_trajectory(job.job, session, result); !written) return written;
  DepthSamples samples;
  if (needs_samples(job.job)) {
    auto read = samples_again(job.job, job.planned, session);
    if (!read) return read.error();
    samples = *std::move(read);
  }
  const auto joined = join_parts(job.job, job.planned.world_up, *bricks, samples, archive_of(job.job), session, result);
  return joined ? joined : with_remedy(joined.error(), folder);
}

}  // namespace

Result<std::size_t> plan_job(const PlanRequest& request, const fs::path& folder, ScanObserver& observer,
                             std::stop_token stop) {
  ScanJob job = request.job;
  ScanSession session(observer, std::move(stop));
  if (auto is_new = check_is_new(folder); !is_new) return is_new.error();
  if (auto possible = check_can_be_planned(job); !possible) return possible.error();
  if (auto possible = check_fits_bricks(job); !possible) return possible.error();
  const auto info = recording_info(job);
  if (!info) return info.error();
  const bool tracks = is_tracked(info->poses) && !request.trajectory;
  auto planned = tracks ? plan_tracked(job, info->world_up, session) : plan_known(request, job, session);
  if (!planned) return planned.error();
  auto made = PartFolder::create(folder);
  if (!made) return made.error();
  const JobHeader header = header_of(job, folder, std::move(planned->warnings));
  if (auto written = JobFolder::write(made->path(), header, planned->scan, request.yaml); !written) {
    return written.error();
  }
  if (auto kept = made->keep_as(folder); !kept) return kept.error();
  return planned->scan.parts.size();
}

Result<JobWork> work_on_job(const fs::path& folder, const ScanConfig& config, const WorkRequest& request,
                            ScanObserver& observer, std::stop_token stop) {
  ScanJob job;
  job.config = config;
  const auto opened = open_job(folder, std::move(job));
  if (!opened) return opened.error();
  ScanSession session(observer, std::move(stop));
  Worker worker(*opened, session);
  if (!request.brick) return worker.all(request.workers);
  if (*request.brick < opened->folder.bricks()) return worker.one(*request.brick);
  return Error{ErrorCode::kUsage,
               fmt::format("there is no brick {}: the job has {}, from 0", *request.brick, opened->folder.bricks()),
               folder.string()};
}

ScanResult join_job(const fs::path& folder, const ScanJob& asked, ScanObserver& observer, std::stop_token stop) {
  ScanSession session(observer, std::move(stop));
  ScanResult result;
  if (auto writable = check_files(asked); !writable) return session.conclude(writable, asked, {});
  auto job = open_job(folder, asked);
  if (!job) return session.conclude(job.error(), asked, {});
  Result<void> outcome = check_fits_bricks(job->job);
  if (outcome) outcome = join(*job, folder, session, result);
  return session.conclude(std::move(outcome), job->job, std::move(result));
}

Result<JobStatus> job_status(const fs::path& folder, BrickCheck check) {
  const auto opened = JobFolder::open(folder);
  return opened ? Result<JobStatus>(status_of(*opened, check)) : opened.error();
}

}  // namespace scanknit
