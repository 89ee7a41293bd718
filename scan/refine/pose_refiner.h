// PoseRefiner: finds better poses for the frames of a scan, after all of them have been tracked and fused.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <optional>

#include "core/frame.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_result.h"

namespace scanknit {

/// The result of tracking, from which a refiner starts.
struct TrackedWalk {
  const Trajectory& trajectory;                   ///< of the frames that were fused
  const std::optional<TrackingResult>& tracking;  ///< nothing where poses are given
  /// To be called before frames are fused into another volume, which may take as much memory as the scan's.
  std::function<Result<void>()> make_room = [] { return Result<void>(); };
};

/// What a refiner found, whether or not its poses were taken.
struct RefinerResult {
  std::vector<TrackedFrame> recovered = {};  ///< frames with a refined pose that tracking had lost
  std::optional<LoopResult> loops = {};
  std::optional<TurntableResult> turntable = {};
  FilesByKind files = {};
};

/// A scan calls prepare() once, edit_for_tracking() and note_fused() for its frames, and start_over() when it begins
/// again; then refine(), at most once. If that returns poses, edit_for_fusion() follows for each frame, then accept()
/// or reject(). An error ends the scan.
class PoseRefiner {
 public:
  virtual ~PoseRefiner() = default;

  /// Called before the first frame: may read all frames.
  [[nodiscard]] virtual Result<void> prepare() { return {}; }
  /// Changes a filtered frame before it is tracked.
  virtual void edit_for_tracking([[maybe_unused]] Frame& frame) const {}
  /// Called after a frame was fused. `follows_gap`: tracking was lost between the last fused frame and this one.
  virtual void note_fused([[maybe_unused]] const Frame& frame, [[maybe_unused]] const Pose& T_world_camera,
                          [[maybe_unused]] bool follows_gap) {}
  /// The scan begins again with the next frame: discards everything that was noted.
  virtual void start_over() {}

  /// True when it can find poses although tracking was lost most of the time.
  [[nodiscard]] virtual bool recovers_lost_scans() const { return false; }
  /// The poses at which to fuse the frames again, into an empty volume; nothing: poses and volume stay as they are,
  /// as they do when the scan was interrupted.
  [[nodiscard]] virtual Result<std::optional<Trajectory>> refine(const TrackedWalk& walk) = 0;

  /// Changes a frame before it is filtered and fused again.
  virtual void edit_for_fusion([[maybe_unused]] Frame& frame) {}
  /// Called when all frames have been fused again into `volume`, which becomes the scan's volume; may cut it.
  [[nodiscard]] virtual Result<void> accept(TsdfVolume& volume) = 0;
  /// Called instead of accept() when not all frames could be fused again: `fused` is their number, or the error. The
  /// scan keeps its tracked poses, unless this returns an error.
  [[nodiscard]] virtual Result<void> reject(const Result<std::size_t>& fused) = 0;

  /// Where accept() left the volume as it was fused, a point in the world; empty: everywhere.
  [[nodiscard]] virtual std::function<bool(const Eigen::Vector3d&)> kept_space() const { return {}; }

  /// True when the world of the refined poses is not that of the tracked ones.
  [[nodiscard]] virtual bool moves_the_world() const { return false; }
  [[nodiscard]] virtual RefinerResult result() const { return {}; }
};

/// Leaves all poses as they are.
class NoRefiner final : public PoseRefiner {
 public:
  [[nodiscard]] Result<std::optional<Trajectory>> refine(const TrackedWalk& /*walk*/) override {
    return std::optional<Trajectory>();
  }
  [[nodiscard]] Result<void> accept(TsdfVolume& /*volume*/) override { return {}; }
  [[nodiscard]] Result<void> reject(const Result<std::size_t>& /*fused*/) override { return {}; }
};

}  // namespace scanknit
