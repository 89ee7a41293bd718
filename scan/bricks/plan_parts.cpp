#include "scan/bricks/plan_parts.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "acquire/filter/depth_filter.h"
#include "fusion/bricks/brick_plan.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/frames/frame_intake.h"

namespace scanknit {
namespace {

class PartPlanner {
 public:
  PartPlanner(const ScanJob& job, const PassInput& input, ScanSession& session, DepthSamples* samples)
      : job_(job), input_(input), session_(session), samples_(samples), plan_(job.config.fusion) {
    planned_.fusion = job.config.fusion;
    planned_.world_up = input.source.info().world_up;
  }

  [[nodiscard]] const FrameCounts& counts() const { return planned_.counts; }

  [[nodiscard]] Result<PlannedScan> plan() {
    if (auto sound = TsdfVolume::create(job_.config.fusion); !sound) return sound.error();
    if (auto read = plan_frames(); !read) return read.error();
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

 private:
  [[nodiscard]] Result<void> plan_frames() {
    FrameIntake intake(input_.source, job_.config.acquire, session_, {input_.stop, input_.counted});
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto added = add(*frame);
      if (!added) return added.error();
      intake.count(*frame, *added);
      session_.progress("planning bricks", intake.counts().read, intake.info().frames);
    }
    planned_.counts = intake.counts();
    if (input_.stop.stop_requested()) return Error{ErrorCode::kInput, "interrupted before the first brick was fused"};
    return intake.conclude();
  }

  [[nodiscard]] Result<Reconstruction::Added> add(Frame& frame) {
    const std::uint32_t checksum = session_.timed("plan", [&] { return checksum_of(frame); });
    if (auto filtered = filter(frame, job_.config, session_); !filtered) return filtered.error();
    const auto added = session_.timed("plan", [&] { return plan_.add(frame, *frame.T_world_camera); });
    if (!added && added.error().code == ErrorCode::kInput) return Reconstruction::Added{{}, added.error()};
    if (!added) return added.error();
    planned_.trajectory.push_back({frame.sequence, stamp_of(frame), *frame.T_world_camera});
    planned_.checksums.push_back(checksum);
    if (samples_ != nullptr) samples_->add(frame);
    return Reconstruction::Added{frame.T_world_camera};
  }

  [[nodiscard]] Result<std::vector<BrickPart>> parts() const {
    const FusionConfig& fusion = job_.config.fusion;
    const std::size_t max_bytes = fusion.memory_budget_mib << 20;
    if (fusion.bricks == BrickSize::kAuto || fusion.bricks == BrickSize::kOff) return parts_within(plan_, max_bytes);
    return parts_of_bricks(plan_, static_cast<int>(fusion.bricks), max_bytes);
  }

  const ScanJob& job_;
  const PassInput& input_;
  ScanSession& session_;
  DepthSamples* samples_;
  BrickPlan plan_;
  PlannedScan planned_;
};

}  // namespace

Result<PlannedScan> plan_parts(const ScanJob& job, const PassInput& input, ScanSession& session, FrameCounts& counts,
                               DepthSamples* samples) {
  PartPlanner planner(job, input, session, samples);
  auto planned = planner.plan();
  counts = planned ? planned->counts : planner.counts();
  return planned;
}

Result<void> filter(Frame& frame, const ScanConfig& config, ScanSession& session) {
  return session.timed("filter", [&] { return filter_frame(frame, config.acquire, config.fusion.noise); });
}

}  // namespace scanknit
