// LoopRefiner: finds places that the walk came back to, and corrects the poses for the drift.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "acquire/acquire_config.h"
#include "fusion/loops/loop_closure.h"
#include "scan/frames/frame_archive.h"
#include "scan/refine/pose_refiner.h"
#include "scan/scan_config.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Only warns when a loop cannot be closed: the mesh of the tracked poses stays.
class LoopRefiner final : public PoseRefiner {
 public:
  /// All references outlive it.
  LoopRefiner(const ScanConfig& config, const FrameArchive& archive, ScanSession& session);

  void note_fused(const Frame& frame, const Pose& T_world_camera, bool follows_gap) override;
  void start_over() override;
  [[nodiscard]] Result<std::optional<Trajectory>> refine(const TrackedWalk& walk) override;
  [[nodiscard]] Result<void> accept(TsdfVolume& volume) override;
  [[nodiscard]] Result<void> reject(const Result<std::size_t>& fused) override;
  [[nodiscard]] RefinerResult result() const override { return {.recovered = recovered_, .loops = result_}; }

 private:
  struct LostFrame {
    PosedFrame posed;
    TrackedFrame tracked;
  };

  void track_lost_end(const TrackedWalk& walk);
  [[nodiscard]] LoopClosure find_loops();
  [[nodiscard]] Result<void> track_again(const std::vector<FrameRange>& ranges);
  [[nodiscard]] Trajectory with_joined_end(Trajectory trajectory, const LoopClosure& closure);
  [[nodiscard]] Trajectory moved(const Trajectory& trajectory, const std::vector<Pose>& T_world_noted) const;
  [[nodiscard]] Result<std::optional<Trajectory>> close(const TrackedWalk& walk, LoopClosure closure);
  [[nodiscard]] LoopResult described(const LoopClosure& closure) const;
  void warn_not_closed(const Error& error);

  const ScanConfig& config_;
  const FrameArchive& archive_;
  ScanSession& session_;
  KeyFrames keys_;
  std::vector<std::uint64_t> fused_;     ///< sequence numbers; then those of lost_end_
  std::vector<LostFrame> lost_end_;      ///< frames that were lost at the end, tracked by themselves
  std::vector<TrackedFrame> recovered_;  ///< those of them that a loop joins to the walk
  std::optional<LoopResult> result_;
  double largest_correction_m_ = 0;
  std::size_t wanted_ = 0;  ///< number of frames to fuse again
};

/// The refiner for frames of a walk: a LoopRefiner if poses are tracked and fusion.loop_closure is on, else a
/// NoRefiner.
[[nodiscard]] std::unique_ptr<PoseRefiner> loop_refiner(const ScanConfig& config, PoseMode poses,
                                                        const FrameArchive& archive, ScanSession& session);

}  // namespace scanknit
