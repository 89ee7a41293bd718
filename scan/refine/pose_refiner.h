// PoseRefiner: better poses for the frames of a scan, once all of them have been tracked and fused.
#pragma once

#include <cstddef>
#include <optional>

#include "core/frame.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_result.h"
#include "scan/trajectory.h"

namespace scanknit {

/// What tracking has found, for a refiner to start from.
struct TrackedWalk {
  const Trajectory& trajectory;                   ///< of the frames that were fused
  const std::optional<TrackingResult>& tracking;  ///< nothing where poses are given
};

/// Its functions are called in the order in which they stand here. Errors end the scan.
class PoseRefiner {
 public:
  virtual ~PoseRefiner() = default;

  /// Changes a filtered frame before it is tracked.
  virtual void edit_for_tracking([[maybe_unused]] Frame& frame) const {}
  /// A frame was fused. `follows_gap`: tracking was lost since the last one.
  virtual void note_fused([[maybe_unused]] const Frame& frame, [[maybe_unused]] const Pose& T_world_camera,
                          [[maybe_unused]] bool follows_gap) {}
  /// The scan begins anew with the next frame: all that was noted is gone.
  virtual void start_over() {}

  /// True: it may find poses where tracking was lost most of the time.
  [[nodiscard]] virtual bool recovers_lost_scans() const { return false; }
  /// Poses at which the frames are to be fused again, in a volume that is empty; nothing: they stay as they are.
  [[nodiscard]] virtual Result<std::optional<Trajectory>> refine(const TrackedWalk& walk) = 0;

  /// Changes a frame before it is filtered and fused again.
  virtual void edit_for_fusion([[maybe_unused]] Frame& frame) {}
  /// All frames have been fused again in `volume`, which becomes the scan's; it may be cut.
  [[nodiscard]] virtual Result<void> accept(TsdfVolume& volume) = 0;
  /// Or not all could be: `fused` frames, or the error that was in the way. The scan stays as it was tracked, unless
  /// this returns an error.
  [[nodiscard]] virtual Result<void> reject(const Result<std::size_t>& fused) = 0;

  /// True: the refined poses are in another world than the tracked ones.
  [[nodiscard]] virtual bool moves_the_world() const { return false; }
  /// Writes what it found into the result.
  virtual void describe(ScanResult& result) const = 0;
};

/// Leaves all poses as they are.
class NoRefiner final : public PoseRefiner {
 public:
  [[nodiscard]] Result<std::optional<Trajectory>> refine(const TrackedWalk& /*walk*/) override {
    return std::optional<Trajectory>();
  }
  [[nodiscard]] Result<void> accept(TsdfVolume& /*volume*/) override { return {}; }
  [[nodiscard]] Result<void> reject(const Result<std::size_t>& /*fused*/) override { return {}; }
  void describe(ScanResult& /*result*/) const override {}
};

}  // namespace scanknit
