// CubeProjector: cubes of the volume as a camera sees them.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/camera.h"
#include "core/pose.h"

namespace scanknit {

/// A cube in the picture. The pixel coordinates mean nothing where it reaches behind the camera.
struct CubeView {
  float x0, y0, x1, y1;  ///< the smallest rectangle round its corners, and a hundredth of a pixel for rounding
  float near_m, far_m;   ///< its z-range
  [[nodiscard]] bool reaches_behind(float z_m) const { return near_m <= z_m; }
};

class CubeProjector {
 public:
  CubeProjector(const CameraIntrinsics& k, const Pose& T_world_camera, double voxel_size_m)
      : eye_(T_world_camera.translation() / voxel_size_m),
        R_((T_world_camera.linear().transpose() * voxel_size_m).cast<float>()),
        fx_(static_cast<float>(k.fx)),
        fy_(static_cast<float>(k.fy)),
        cx_(static_cast<float>(k.cx)),
        cy_(static_cast<float>(k.cy)) {
    for (std::size_t i = 0; i < 8; ++i) {
      const Eigen::Vector3f corner = R_ * Eigen::Vector3f((i & 1) != 0, (i & 2) != 0, (i & 4) != 0);
      x_[i] = corner.x();
      y_[i] = corner.y();
      z_[i] = corner.z();
    }
    const auto [least, greatest] = std::minmax_element(z_.begin(), z_.end());
    least_z_ = *least;
    greatest_z_ = *greatest;
  }

  /// The cube from `low` + `offset` along each axis, `edge` voxels long.
  [[nodiscard]] CubeView view(const openvdb::Coord& low, float offset, float edge) const {
    const Eigen::Vector3d from_eye = Eigen::Vector3d(low.x(), low.y(), low.z()) - eye_;
    const Eigen::Vector3f first = R_ * (from_eye.cast<float>() + Eigen::Vector3f::Constant(offset));
    CubeView view{1e30f, 1e30f, -1e30f, -1e30f, first.z() + edge * least_z_, first.z() + edge * greatest_z_};
    if (view.reaches_behind(0)) return view;
    for (std::size_t i = 0; i < 8; ++i) {
      const float per_z = 1 / (first.z() + edge * z_[i]);
      const float x = (first.x() + edge * x_[i]) * per_z;
      const float y = (first.y() + edge * y_[i]) * per_z;
      view.x0 = std::min(view.x0, x);
      view.x1 = std::max(view.x1, x);
      view.y0 = std::min(view.y0, y);
      view.y1 = std::max(view.y1, y);
    }
    to_pixels(fx_, cx_, view.x0, view.x1);
    to_pixels(fy_, cy_, view.y0, view.y1);
    return view;
  }

 private:
  static void to_pixels(float focal, float centre, float& low, float& high) {
    constexpr float kSlack = 0.01f;
    const float a = focal * low + centre;
    const float b = focal * high + centre;
    low = std::min(a, b) - kSlack;
    high = std::max(a, b) + kSlack;
  }

  Eigen::Vector3d eye_;             ///< voxels
  Eigen::Matrix3f R_;               ///< R_camera_world, and voxels to metres
  std::array<float, 8> x_, y_, z_;  ///< corners of a cube of one voxel, from its lowest
  float least_z_, greatest_z_;
  float fx_, fy_, cx_, cy_;
};

}  // namespace scanknit
