// LookThrough: removes points that other frames see through, since these do not belong to the object.
#pragma once

#include <cstddef>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/noise_model.h"
#include "fusion/turntable/turntable_axis.h"

namespace scanknit {

/// Removes a hand, or anything else that does not turn with the table: where one frame sees a point of it, the other
/// frames see something farther away.
class LookThrough {
 public:
  LookThrough(const TurntableAxis& axis, const NoiseModel& noise) : axis_(axis), noise_(noise) {}

  /// Adds a frame with the background behind the object, to compare other frames with: about forty, from the whole
  /// recording.
  void add_witness(DepthImage depth_m, const CameraIntrinsics& camera, double angle_rad);
  [[nodiscard]] std::size_t witnesses() const { return witnesses_.size(); }

  /// Sets depth to 0 at points that more witnesses see through than see. Returns the number of such pixels. The same
  /// for any number of threads.
  std::size_t remove_from(DepthImage& depth_m, const CameraIntrinsics& camera, double angle_rad) const;

 private:
  struct Witness {
    DepthImage depth_m;
    CameraIntrinsics camera;
    double angle_rad;
  };
  enum class Evidence { kNothing, kThere, kNotThere };
  [[nodiscard]] Evidence evidence_of(const Witness& witness, const Eigen::Vector3d& p_witness) const;

  TurntableAxis axis_;
  NoiseModel noise_;
  std::vector<Witness> witnesses_;
};

}  // namespace scanknit
