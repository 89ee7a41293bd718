#include "scan/job/job_estimate.h"

#include <algorithm>
#include <ctime>
#include <map>
#include <queue>
#include <set>
#include <system_error>
#include <utility>

#include "scan/bricks/fuse_parts.h"
#include "scan/checks/memory_share.h"
#include "scan/job/job_costs.h"
#include "scan/job/open_job.h"

namespace scanknit {
namespace {

constexpr double kMebibyteBytes = 1024.0 * 1024.0;

double as_double(std::size_t count) {
  return static_cast<double>(count);
}

/// Pairs of bricks that share a face.
std::size_t count_seams(const std::vector<BrickPart>& parts) {
  std::map<openvdb::Coord, std::size_t> owner;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (const openvdb::Coord& region : parts[i].regions) owner[region] = i;
  }
  std::set<std::pair<std::size_t, std::size_t>> seams;
  for (const auto& [region, number] : owner) {
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Coord beside = region;
      beside[axis] += kRegionVoxels;
      const auto other = owner.find(beside);
      if (other != owner.end() && other->second != number) seams.insert(std::minmax(number, other->second));
    }
  }
  return seams.size();
}

/// Follows the workers as they take their shares (brick_job.cpp).
class Schedule {
 public:
  Schedule(const PlannedScan& planned, const JobEstimate& estimate, std::size_t workers)
      : planned_(planned), estimate_(estimate), workers_(workers) {
    for (std::size_t i = 0; i < planned.parts.size(); ++i) left_.insert(left_.end(), i);
    for (const BrickPart& part : planned.parts) work_left_ += work_of(part);
  }

  void follow() {
    using Free = std::pair<double, std::size_t>;  // when, and which worker
    std::priority_queue<Free, std::vector<Free>, std::greater<>> free;
    const std::size_t count = std::max<std::size_t>(1, workers_);
    for (std::size_t i = 0; i < count; ++i) free.push({estimate_.start.s, i});
    work_s = as_double(count) * estimate_.start.s;
    WorkPlace first(share());
    auto behind = left_.begin();  // what other workers take first
    for (std::size_t begun = 0; !left_.empty(); ++begun) {
      const auto [now_s, worker] = free.top();
      free.pop();
      PartGroup group;
      if (begun < count && behind != left_.end()) {
        const std::size_t number = first.share_of(planned_.parts[*behind]);
        group = take(behind, first);
        while (behind != left_.end() && first.share_of(planned_.parts[*behind]) == number) {
          first.pass(planned_.parts[*behind++]);
        }
      } else {
        WorkPlace place(share());
        auto next = left_.begin();
        group = take(next, place);
      }
      const double spent_s = seconds_of(group);
      work_s += spent_s;
      longest_s = std::max(longest_s, now_s + spent_s);
      free.push({now_s + spent_s, worker});
    }
    longest_s = std::max(longest_s, estimate_.start.s);
  }

  double work_s = 0, longest_s = 0;
  std::size_t most_blocks = 0;  ///< of a group

 private:
  using Left = std::set<std::size_t>;

  [[nodiscard]] double share() const { return workers_ == 0 ? 0 : work_left_ / as_double(workers_); }

  [[nodiscard]] PartGroup take(Left::const_iterator& next, WorkPlace& place) {
    const std::size_t max_bytes = volume_budget_mib(planned_.fusion.memory_budget_mib) << 20;
    const std::size_t number = place.share_of(planned_.parts[*next]);
    PartGroup group;
    std::size_t bytes = 0, blocks = 0;
    while (next != left_.end() && place.share_of(planned_.parts[*next]) == number) {
      const BrickPart& part = planned_.parts[*next];
      if (!group.empty() && bytes + part.most_bytes > max_bytes) break;
      bytes += part.most_bytes;
      blocks += estimate_.bricks[*next].blocks;
      group.push_back(*next);
      place.pass(part);
      work_left_ -= work_of(part);
      next = left_.erase(next);
    }
    most_blocks = std::max(most_blocks, blocks);
    return group;
  }

  [[nodiscard]] double seconds_of(const PartGroup& group) const {
    std::vector<FrameRun> frames;
    double s = 0;
    for (const std::size_t number : group) {
      const auto& runs = planned_.parts[number].frames;
      frames.insert(frames.end(), runs.begin(), runs.end());
      const JobEstimate::Brick& brick = estimate_.bricks[number];
      s += brick.s - as_double(brick.frames) * estimate_.frame.s;
    }
    return s + as_double(count_frames(joined_runs(std::move(frames)))) * estimate_.frame.s;
  }

  const PlannedScan& planned_;
  const JobEstimate& estimate_;
  std::size_t workers_;
  Left left_;
  double work_left_ = 0;
};

/// What all bricks take, one by one.
void add_bricks(const PlannedScan& planned, const JobCosts& costs, JobEstimate& all) {
  std::vector<FrameRun> frames;
  double readings = 0;
  for (const BrickPart& part : planned.parts) {
    JobEstimate::Brick brick{count_frames(part.frames), planned_blocks(part)};
    const double own_s = costs.update_s * as_double(brick.frames) * as_double(brick.blocks);
    brick.s = as_double(brick.frames) * costs.frame_s + own_s;
    brick.bytes = costs.bytes_per_block * as_double(brick.blocks);
    readings += as_double(brick.frames);
    all.brick.s += own_s / as_double(planned.parts.size());
    all.brick.bytes += brick.bytes / as_double(planned.parts.size());
    frames.insert(frames.end(), part.frames.begin(), part.frames.end());
    all.bricks.push_back(brick);
  }
  all.seams = count_seams(planned.parts);
  if (all.seams == 0) return;
  const double anew = (readings - as_double(count_frames(joined_runs(std::move(frames))))) / as_double(all.seams);
  all.seam = {anew * all.frame.s, anew * all.frame.bytes};
}

}  // namespace

JobEstimate estimate(const PlannedScan& planned, const JobCosts& costs, std::size_t workers) {
  // Fitted to whole jobs of docs/scale.md, for what a few bricks do not show: a mesh that is larger than the
  // processor's caches; what allocation and writing take beside a volume; a mesh while it is finished, without colours
  // for textures.
  constexpr double kLargeMesh = 1.15, kBesideVolume = 1.25, kJoinBytesPerTriangle = 140;
  JobEstimate all;
  all.workers = workers;
  all.start = {costs.start_s, 0};
  all.frame = {costs.frame_s, costs.frame_bytes};
  all.join_start = {costs.join_start_s, 0};
  all.join_s_per_byte = kLargeMesh * costs.join_s_per_byte;
  all.frames = planned.trajectory.size();
  all.sampled = costs.sampled;
  add_bricks(planned, costs, all);
  const double brick_bytes = all.brick.bytes * as_double(all.bricks.size());
  Schedule schedule(planned, all, workers);
  schedule.follow();
  all.plan_s = costs.plan_s;
  all.work_s = schedule.work_s;
  all.join_s = costs.start_s + costs.join_start_s + all.join_s_per_byte * brick_bytes;
  all.wall_s = all.plan_s + schedule.longest_s + all.join_s;
  all.triangles = costs.triangles_per_byte * brick_bytes;
  all.worker_mib =
      costs.process_mib + kBesideVolume * costs.memory_per_block * as_double(schedule.most_blocks) / kMebibyteBytes;
  all.join_mib = costs.process_mib + all.triangles * kJoinBytesPerTriangle / kMebibyteBytes;
  all.folder_bytes = brick_bytes;
  return all;
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Result<JobEstimate> estimate_job(const std::filesystem::path& folder, const EstimateRequest& request,
                                 ScanObserver& observer, std::stop_token stop) {
  const double begin_s = processor_seconds();
  const auto job = open_job(folder, request.join);
  if (!job) return job.error();
  const double start_s = processor_seconds() - begin_s;
  ScanSession session(observer, std::move(stop));
  ScanJob join = job->job;
  auto costs = measure_costs(*job, join, request.scratch, session);
  if (!costs) return costs.error();
  costs->plan_s = request.plan_s;
  costs->start_s = request.process_s + start_s;
  JobEstimate all = estimate(job->planned, *costs, request.workers);
  std::error_code code;
  const auto plan_bytes = std::filesystem::file_size(folder / "plan", code);
  if (!code) all.folder_bytes += static_cast<double>(plan_bytes);
  return all;
}

}  // namespace scanknit
