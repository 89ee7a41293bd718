#include "scan/bricks/plan_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "fusion/bricks/brick_plan.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/bricks/planned_frames.h"
#include "scan/checks/memory_share.h"
#include "scan/frames/frame_intake.h"

namespace scanknit {
namespace {

class PartPlanner {
 public:
  PartPlanner(const ScanJob& job, UpAxis world_up, PoseOrigin poses, ScanSession& session)
      : job_(job), session_(session), plan_(job.config.fusion) {
    planned_.fusion = job.config.fusion;
    planned_.world_up = world_up;
    planned_.poses = poses;
  }

  [[nodiscard]] const FrameCounts& counts() const { return planned_.counts; }

  /// Reads frames that have poses. `samples`, unless null, gets them.
  [[nodiscard]] Result<PlannedScan> plan(const PassInput& input, DepthSamples* samples) {
    if (auto sound = TsdfVolume::create(job_.config.fusion); !sound) return sound.error();
    if (auto read = plan_frames(input, samples); !read) return read.error();
    const std::size_t spacing = DepthSamples::spacing(planned_.trajectory.size());
    for (std::size_t i = 0; i < planned_.trajectory.size(); i += spacing) {
      planned_.samples.push_back(static_cast<std::uint32_t>(i + 1));
    }
    return divided();
  }

  /// Reads the frames whose poses were found, again.
  [[nodiscard]] Result<PlannedScan> plan(const FoundPoses& found) {
    if (auto read = plan_found(found.scan.trajectory, found.fused); !read) return read.error();
    for (const std::uint64_t sequence : found.samples) {
      const auto at = std::find_if(planned_.trajectory.begin(), planned_.trajectory.end(),
                                   [&](const PosedFrame& posed) { return posed.sequence == sequence; });
      if (at == planned_.trajectory.end()) continue;
      planned_.samples.push_back(static_cast<std::uint32_t>(at - planned_.trajectory.begin()) + 1);
    }
    planned_.counts = found.scan.frames;
    planned_.tracked = {found.scan.tracking, found.scan.loops, found.scan.config.acquire.timing()};
    return divided();
  }

 private:
  [[nodiscard]] Result<void> plan_frames(const PassInput& input, DepthSamples* samples) {
    FrameIntake intake(input.source, job_.config.acquire, session_, {input.stop, input.counted});
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto added = add(*frame, {frame->sequence, stamp_of(*frame), *frame->T_world_camera});
      if (!added) return added.error();
      intake.count(*frame, *added);
      if (samples != nullptr && !added->refused) samples->add(*frame);
      session_.progress("planning bricks", intake.counts().read, intake.info().frames);
    }
    planned_.counts = intake.counts();
    if (input.stop.stop_requested()) return interrupted();
    return intake.conclude();
  }

  [[nodiscard]] Result<void> plan_found(const Trajectory& trajectory, const std::vector<std::uint64_t>& order) {
    std::map<std::uint64_t, const PosedFrame*> posed;
    for (const PosedFrame& frame : trajectory) posed[frame.sequence] = &frame;
    Trajectory fused;
    for (const std::uint64_t sequence : order) fused.push_back(*posed.at(sequence));
    ScanJob reading = job_;
    reading.config.acquire.poses = PoseMode::kStill;  // whatever the recording's
    const std::vector<FrameRun> all = {{1, static_cast<std::uint32_t>(fused.size())}};
    const auto read =
        for_each_numbered(reading, fused, all, session_, [&](Frame& frame, std::uint32_t number) -> Result<void> {
          const auto added = add(frame, fused[number - 1]);
          if (!added) return added.error();
          session_.progress("planning bricks", number, fused.size());
          return added->refused ? Result<void>(*added->refused) : Result<void>();
        });
    if (!read) return read.error();
    return *read ? Result<void>() : interrupted();
  }

  [[nodiscard]] Result<Reconstruction::Added> add(Frame& frame, const PosedFrame& posed) {
    const std::uint32_t checksum = session_.timed("plan", [&] { return checksum_of(frame, planned_.poses); });
    frame.colour.reset();  // of no use here
    if (auto prepared = prepare(frame, posed.motion, job_.config, session_); !prepared) return prepared.error();
    const auto added = session_.timed("plan", [&] { return plan_.add(frame, posed.T_world_camera); });
    if (!added && added.error().code == ErrorCode::kInput) return Reconstruction::Added{{}, added.error()};
    if (!added) return added.error();
    planned_.trajectory.push_back(posed);
    planned_.checksums.push_back(checksum);
    return Reconstruction::Added{posed.T_world_camera};
  }

  [[nodiscard]] static Error interrupted() {
    return {ErrorCode::kInput, "interrupted before the first brick was fused"};
  }

  [[nodiscard]] Result<PlannedScan> divided() {
    auto parts = this->parts();
    if (!parts) return parts.error();
    planned_.parts = *std::move(parts);
    std::size_t readings = 0;
    for (const BrickPart& part : planned_.parts) readings += count_frames(part.frames);
    session_.info(fmt::format("the volume is fused in {} parts; a frame is fused into {:.1f} of them on average",
                              planned_.parts.size(),
                              static_cast<double>(readings) / static_cast<double>(plan_.frames())));
    return std::move(planned_);
  }

  [[nodiscard]] Result<std::vector<BrickPart>> parts() const {
    const FusionConfig& fusion = job_.config.fusion;
    const std::size_t max_bytes = volume_budget_mib(fusion.memory_budget_mib) << 20;
    if (fusion.bricks == BrickSize::kAuto || fusion.bricks == BrickSize::kOff) return parts_within(plan_, max_bytes);
    return parts_of_bricks(plan_, static_cast<int>(fusion.bricks), max_bytes);
  }

  const ScanJob& job_;
  ScanSession& session_;
  BrickPlan plan_;
  PlannedScan planned_;
};

}  // namespace

Result<PlannedScan> plan_parts(const ScanJob& job, const PassInput& input, PoseOrigin poses, ScanSession& session,
                               FrameCounts& counts, DepthSamples* samples) {
  PartPlanner planner(job, input.source.info().world_up, poses, session);
  auto planned = planner.plan(input, samples);
  counts = planned ? planned->counts : planner.counts();
  return planned;
}

Result<PlannedScan> plan_parts(const ScanJob& job, const FoundPoses& found, UpAxis world_up, ScanSession& session) {
  return PartPlanner(job, world_up, PoseOrigin::kPlan, session).plan(found);
}

}  // namespace scanknit
