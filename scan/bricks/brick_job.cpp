#include "scan/bricks/brick_job.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "acquire/lidar/sweep_source.h"
#include "fusion/bricks/brick_volume.h"
#include "scan/bricks/brick_claim.h"
#include "scan/bricks/bricks_check.h"
#include "scan/bricks/fuse_part.h"
#include "scan/bricks/job_folder.h"
#include "scan/bricks/join_parts.h"
#include "scan/bricks/part_folder.h"
#include "scan/bricks/plan_parts.h"
#include "scan/checks/settings_check.h"
#include "scan/frames/recorded_frames.h"

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

/// check_bricks(), for a person who asked for nothing else.
Result<void> check_fits_bricks(const ScanJob& job, PoseMode poses) {
  const Result<void> possible = check_bricks(job, poses);
  if (possible) return {};
  return Error{ErrorCode::kUsage, possible.error().message + "; scanknit run fuses it in one process",
               job.input.string()};
}

JobHeader header_of(const ScanJob& job, const fs::path& folder, const ScanSession& session) {
  std::error_code code;
  JobHeader header;
  header.near_recording = near_place(job.input, folder);
  header.far_recording = fs::absolute(job.input, code).lexically_normal().string();
  header.from = job.config.acquire.from;
  header.to = job.config.acquire.to;
  header.every = job.config.acquire.every;
  header.warnings = session.warnings();
  return header;
}

/// A job that was planned, and its recording.
struct OpenJob {
  JobFolder folder;
  ScanJob job;  ///< its configuration is complete
  PlannedScan planned;
};

/// `job`: with the configuration from config_file_of_job().
Result<OpenJob> open_job(const fs::path& folder, ScanJob job) {
  auto opened = JobFolder::open(folder);
  if (!opened) return opened.error();
  job.input = opened->recording();
  job.config.acquire.from = opened->header().from;
  job.config.acquire.to = opened->header().to;
  job.config.acquire.every = opened->header().every;
  ScanObserver silent;  // plan_job() told it already
  ScanSession session(silent, {});
  if (const auto first = open_first(job, session); !first) return first.error();
  auto planned = opened->planned(job.config.fusion);
  if (!planned) return planned.error();
  return OpenJob{*std::move(opened), std::move(job), *std::move(planned)};
}

class Worker {
 public:
  Worker(const OpenJob& job, ScanSession& session) : job_(job), session_(session) {}

  [[nodiscard]] Result<JobWork> all() {
    const std::size_t count = job_.folder.bricks();
    for (std::size_t i = 0; i < count && !session_.is_stopped(); ++i) {
      if (!job_.folder.is_done(i)) {
        if (auto fused = fuse(i); !fused) return fused.error();
      }
      session_.progress("fusing bricks", i + 1, count);
    }
    work_.is_stopped = session_.is_stopped();
    return work_;
  }

  [[nodiscard]] Result<JobWork> one(std::size_t number) {
    const auto file = BrickFile::open(job_.folder.brick(number), job_.folder.id());
    std::error_code code;
    if (file && !file->is_whole()) fs::remove(job_.folder.brick(number), code);
    if (!file || !file->is_whole()) {
      if (auto fused = fuse(number); !fused) return fused.error();
    }
    work_.is_stopped = session_.is_stopped();
    return work_;
  }

 private:
  /// Fuses a brick that is not done, unless another worker is at it.
  [[nodiscard]] Result<void> fuse(std::size_t number) {
    const auto claim = BrickClaim::take(job_.folder.claim(number));
    if (!claim) return claim.error();
    if (*claim == nullptr) {
      ++work_.elsewhere;
      return {};
    }
    if (job_.folder.is_done(number)) return {};  // since it was looked for
    const auto fused = fuse_part(job_.job, job_.planned, number, job_.folder.id(), job_.folder.brick(number), session_);
    if (!fused) return fused.error();
    if (*fused) ++work_.fused;
    return {};
  }

  const OpenJob& job_;
  ScanSession& session_;
  JobWork work_;
};

JobStatus status_of(const JobFolder& folder) {
  JobStatus status;
  status.recording = folder.recording().string();
  status.bricks = folder.bricks();
  std::error_code code;
  for (std::size_t i = 0; i < folder.bricks(); ++i) {
    if (folder.is_done(i)) {
      ++status.done;
      continue;
    }
    const auto is_taken = BrickClaim::is_taken(folder.claim(i));
    const bool is_in_work = is_taken ? *is_taken : fs::exists(folder.claim(i), code);
    ++(is_in_work ? status.in_work : status.free);
    if (!is_in_work && fs::exists(folder.brick(i), code)) ++status.torn;
  }
  return status;
}

Result<BrickVolume> all_bricks(const OpenJob& job, const fs::path& folder) {
  const JobStatus status = status_of(job.folder);
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
  result.trajectory = job.planned.trajectory;
  const auto bricks = all_bricks(job, folder);
  if (!bricks) return bricks.error();
  if (auto written = write_trajectory(job.job, session, result); !written) return written;
  DepthSamples samples;
  if (needs_samples(job.job)) {
    auto read = samples_again(job.job, job.planned, session);
    if (!read) return read.error();
    samples = *std::move(read);
  }
  const auto joined = join_parts(job.job, job.planned, *bricks, samples, archive_of(job.job), session, result);
  return joined ? joined : with_remedy(joined.error(), folder);
}

}  // namespace

Result<std::size_t> plan_job(const ScanJob& asked, const std::string& yaml, const fs::path& folder,
                             ScanObserver& observer, std::stop_token stop) {
  ScanJob job = asked;
  ScanSession session(observer, std::move(stop));
  if (auto is_new = check_is_new(folder); !is_new) return is_new.error();
  if (auto possible = check_can_be_planned(job); !possible) return possible.error();
  const auto opened = open_first(job, session);
  if (!opened) return opened.error();
  FrameSource& source = *opened->source;
  if (auto possible = check_fits_bricks(job, source.info().poses); !possible) return possible.error();
  if (auto told = observer.on_open(source.info()); !told) return told.error();
  const FrameArchive archive = archive_of(job);
  FrameCounts counts;
  const auto planned =
      plan_parts(job, {.source = source, .archive = archive, .stop = session.stop()}, session, counts, nullptr);
  if (!planned) return planned.error();
  auto made = PartFolder::create(folder);
  if (!made) return made.error();
  if (auto written = JobFolder::write(made->path(), header_of(job, folder, session), *planned, yaml); !written) {
    return written.error();
  }
  if (auto kept = made->keep_as(folder); !kept) return kept.error();
  return planned->parts.size();
}

Result<JobWork> work_on_job(const fs::path& folder, const ScanConfig& config, std::optional<std::size_t> brick,
                            ScanObserver& observer, std::stop_token stop) {
  ScanJob job;
  job.config = config;
  const auto opened = open_job(folder, std::move(job));
  if (!opened) return opened.error();
  ScanSession session(observer, std::move(stop));
  Worker worker(*opened, session);
  if (!brick) return worker.all();
  if (*brick < opened->folder.bricks()) return worker.one(*brick);
  return Error{ErrorCode::kUsage,
               fmt::format("there is no brick {}: the job has {}, from 0", *brick, opened->folder.bricks()),
               folder.string()};
}

ScanResult join_job(const fs::path& folder, const ScanJob& asked, ScanObserver& observer, std::stop_token stop) {
  ScanSession session(observer, std::move(stop));
  ScanResult result;
  if (auto writable = check_files(asked); !writable) return session.conclude(writable, asked, {});
  auto job = open_job(folder, asked);
  if (!job) return session.conclude(job.error(), asked, {});
  // Its poses are known: it was planned.
  Result<void> outcome = check_fits_bricks(job->job, PoseMode::kRecording);
  if (outcome) outcome = join(*job, folder, session, result);
  return session.conclude(std::move(outcome), job->job, std::move(result));
}

Result<JobStatus> job_status(const fs::path& folder) {
  const auto opened = JobFolder::open(folder);
  return opened ? Result<JobStatus>(status_of(*opened)) : opened.error();
}

}  // namespace scanknit
