// LoopRefiner: finds places that the walk came back to, and corrects the poses for the drift.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "acquire/acquire_config.h"
#include "fusion/loops/loop_closure.h"
#include "scan/frames/frame_archive.h"
#include "scan/refine/lost_runs.h"
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
  /// A lost run whose frames are among those that were noted.
  struct NotedRun {
    std::optional<std::uint64_t> before, after;  ///< sequence numbers of the nearest known frames
    std::size_t first;                           ///< the place of its first frame in fused_
    FoundRun found;
  };
  /// Of a run's frames: those with a number less than `up_to`, and those from `from` on.
  struct JoinedFrames {
    std::size_t up_to, from;
  };

  [[nodiscard]] Result<void> track_lost_runs(const TrackedWalk& walk);
  void note_run(const LostRun& run, FoundRun found);
  void insert(std::size_t at, FoundSide& side, const KeyFrames::Gaps& gaps);
  [[nodiscard]] LoopClosure find_loops();
  [[nodiscard]] Result<void> track_again(const std::vector<FrameRange>& ranges, const TrackedWalk& walk);
  [[nodiscard]] bool is_of_lost_run(std::size_t noted) const;
  [[nodiscard]] JoinedFrames joined_by_loops(const NotedRun& run, const LoopClosure& closure) const;
  [[nodiscard]] Trajectory with_joined_runs(Trajectory trajectory, const PosesBySequence& known,
                                            const LoopClosure& closure);
  [[nodiscard]] Trajectory moved(const Trajectory& trajectory, const std::vector<Pose>& T_world_noted) const;
  [[nodiscard]] Result<std::optional<Trajectory>> close(const TrackedWalk& walk, LoopClosure closure);
  [[nodiscard]] LoopResult described(const LoopClosure& closure) const;
  void warn_not_closed(const Error& error);
  void warn_not_found(const Error& error);

  const ScanConfig& config_;
  const FrameArchive& archive_;
  ScanSession& session_;
  KeyFrames keys_;
  std::vector<std::uint64_t> fused_;     ///< sequence numbers of the frames that were noted, in order
  std::vector<NotedRun> runs_;           ///< frames that were lost, tracked apart from the scan
  std::vector<TrackedFrame> recovered_;  ///< those of them that are joined to the walk
  std::optional<LoopResult> result_;
  bool colour_is_timely_ = false;  ///< its time was searched for
  bool is_corrected_ = false;      ///< the drift is worth a correction
  double largest_correction_m_ = 0;
  std::size_t wanted_ = 0;  ///< number of frames to fuse again
};

/// The refiner for frames of a walk: a LoopRefiner if poses are tracked and fusion.loop_closure is on, else a
/// NoRefiner.
[[nodiscard]] std::unique_ptr<PoseRefiner> loop_refiner(const ScanConfig& config, PoseMode poses,
                                                        const FrameArchive& archive, ScanSession& session);

}  // namespace scanknit
