// LookThrough: what other frames look through was not there when they were taken, and does not belong to the object.
#pragma once

#include <cstddef>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/noise_model.h"
#include "fusion/turntable/turntable_axis.h"

namespace scanknit {

/// A hand, or anything that does not turn with the table: a point of it that one frame sees is gone for the others,
/// whose depth there lies behind it.
class LookThrough {
 public:
  LookThrough(const TurntableAxis& axis, const NoiseModel& noise) : axis_(axis), noise_(noise) {}

  /// A frame with what stands behind the object in it, to compare others with: some forty, from all of a recording.
  void add_witness(DepthImage depth_m, const CameraIntrinsics& camera, double angle_rad);
  [[nodiscard]] std::size_t witnesses() const { return witnesses_.size(); }

  /// Depth at points that more witnesses look through than see becomes 0. Returns how many pixels that were. The same
  /// for any number of threads.
  std::size_t remove_from(DepthImage& depth_m, const CameraIntrinsics& camera, double angle_rad) const;

 private:
  struct Witness {
    DepthImage depth_m;
    CameraIntrinsics camera;
    double angle_rad;
  };
  enum class Says { kNothing, kThere, kNotThere };
  [[nodiscard]] Says ask(const Witness& witness, const Eigen::Vector3d& p_witness) const;

  TurntableAxis axis_;
  NoiseModel noise_;
  std::vector<Witness> witnesses_;
};

}  // namespace scanknit
