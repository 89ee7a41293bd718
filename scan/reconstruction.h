// Reconstruction: a volume that grows frame by frame.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/frame_source.h"
#include "core/frame.h"
#include "core/result.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/frames/depth_samples.h"
#include "scan/pose_finder.h"
#include "scan/refine/pose_refiner.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

class Reconstruction {
 public:
  struct Options {
    PoseMode poses = PoseMode::kTrack;  ///< not kAuto
    bool keeps_depth_samples = false;   ///< keep some depth frames, to compare the mesh with
    bool warns_when_full = true;        ///< the volume has reached its budget, and the scan goes on
  };

  /// `config`, `refiner` and `session` outlive it. Errors: TsdfVolume::create().
  [[nodiscard]] static Result<Reconstruction> create(const ScanConfig& config, const Options& options,
                                                     PoseRefiner& refiner, ScanSession& session);

  /// What became of a frame.
  struct Added {
    std::optional<Pose> T_world_camera = std::nullopt;  ///< the pose at which it was fused; nothing: it was not fused
    std::optional<Error> refused = std::nullopt;        ///< why the volume refused its pose; nothing: tracking is lost
  };

  /// Filters the frame, finds its pose and fuses it. An error ends the scan.
  [[nodiscard]] Result<Added> add(Frame& frame);

  /// Looks for the frames that were lost, now that the volume holds what was scanned before and after them, and fuses
  /// those that it finds. `source` gives all frames again. Errors: those of the source and of integrate().
  [[nodiscard]] Result<void> find_lost(FrameSource& source);

  /// Empties the volume and the trajectory; the volume keeps its address. Errors: TsdfVolume::create().
  [[nodiscard]] Result<void> start_over();

  /// Replaces volume and trajectory by those of the same frames, some of them, or also some that were lost, fused at
  /// other poses; the volume keeps its address. `recovered`: those that were lost.
  void replace(TsdfVolume volume, Trajectory trajectory, std::span<const TrackedFrame> recovered);

  [[nodiscard]] TsdfVolume& volume() { return volume_; }
  [[nodiscard]] const TsdfVolume& volume() const { return volume_; }
  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] const std::optional<TrackingResult>& tracking() const { return poses_.tracking(); }
  /// Some of the fused frames, filtered, with their current poses.
  [[nodiscard]] std::vector<PosedDepth> depth_samples() const { return samples_.posed(trajectory_); }
  /// Frame::sequence of those frames.
  [[nodiscard]] std::vector<std::uint64_t> sample_sequences() const { return samples_.sequences(); }
  /// Frame::sequence of the frames in the volume, in the order in which they were fused: that of the trajectory, but
  /// those that find_lost() found come after the others.
  [[nodiscard]] std::vector<std::uint64_t> fused_order() const;
  [[nodiscard]] bool is_budget_reached() const { return volume_.is_budget_reached; }

 private:
  Reconstruction(const ScanConfig& config, const Options& options, PoseRefiner& refiner, ScanSession& session,
                 TsdfVolume volume)
      : config_(config),
        options_(options),
        refiner_(refiner),
        session_(session),
        volume_(std::move(volume)),
        poses_(options.poses, config.acquire.timing()) {}
  [[nodiscard]] Result<IntegrateStats> integrate_straightened(Frame& frame, const PoseFinder::Found& found);
  [[nodiscard]] Result<void> fuse_later(Frame& frame, const TrackResult& found);
  [[nodiscard]] Result<void> begin_again(const FrameMotion& motion);
  [[nodiscard]] Result<Added> fuse(Frame& frame, const PoseFinder::Found& found);
  void note_fused(const Frame& frame, const PoseFinder::Found& found);

  const ScanConfig& config_;
  Options options_;
  PoseRefiner& refiner_;
  ScanSession& session_;
  TsdfVolume volume_;
  PoseFinder poses_;
  Trajectory trajectory_;
  std::vector<std::uint64_t> fused_later_;  ///< by find_lost(), in this order
  DepthSamples samples_;
  std::optional<Frame> first_;  ///< filtered, not deskewed; kept until the second is tracked
  bool follows_gap_ = false;    ///< tracking was lost since the last frame that was fused
};

[[nodiscard]] VolumeResult described(const TsdfVolume& volume);

}  // namespace scanknit
