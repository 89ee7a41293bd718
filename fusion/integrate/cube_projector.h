// CubeProjector: projects cubes of the volume into a camera.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/camera.h"
#include "core/pose.h"

namespace scanknit {

/// A cube in the picture. The pixel coordinates are undefined if the cube reaches behind the camera.
struct CubeView {
  float x0, y0, x1, y1;  ///< the bounding rectangle of its corners, plus a hundredth of a pixel for rounding
  float near_m, far_m;   ///< its z-range
  [[nodiscard]] bool reaches_behind(float z_m) const { return near_m <= z_m; }
};

/// The CubeViews of the eight octants of a cube: bit 0 of the index is x, bit 1 is y, bit 2 is z.
struct CubeViews {
  using Numbers = Eigen::Array<float, 8, 1>;
  Numbers x0, y0, x1, y1, near_m, far_m;
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
    for (Eigen::Index i = 0; i < 8; ++i) {
      const Eigen::Vector3f corner = R_ * Eigen::Vector3f((i & 1) != 0, (i & 2) != 0, (i & 4) != 0);
      x_[i] = corner.x();
      y_[i] = corner.y();
      z_[i] = corner.z();
    }
    least_z_ = z_.minCoeff();
    greatest_z_ = z_.maxCoeff();
  }

  /// The cube from `low` + `offset` along each axis, `edge` voxels long.
  [[nodiscard]] CubeView view(const openvdb::Coord& low, float offset, float edge) const {
    const Eigen::Vector3f first = in_camera(low, offset);
    CubeView view{1e30f, 1e30f, -1e30f, -1e30f, first.z() + edge * least_z_, first.z() + edge * greatest_z_};
    if (view.reaches_behind(0)) return view;
    const Corners per_z = (edge * z_ + first.z()).inverse();
    const Corners x = (edge * x_ + first.x()) * per_z;
    const Corners y = (edge * y_ + first.y()) * per_z;
    view.x0 = x.minCoeff();
    view.x1 = x.maxCoeff();
    view.y0 = y.minCoeff();
    view.y1 = y.maxCoeff();
    to_pixels(fx_, cx_, view.x0, view.x1);
    to_pixels(fy_, cy_, view.y0, view.y1);
    return view;
  }

  /// True if the part of the cube in front of the camera is entirely on one side of the picture. Also valid for cubes
  /// that reach behind the camera.
  [[nodiscard]] bool is_beside(const openvdb::Coord& low, float offset, float edge, int width, int height) const {
    const Eigen::Vector3f first = in_camera(low, offset);
    const Corners x = fx_ * (edge * x_ + first.x()), y = fy_ * (edge * y_ + first.y()), z = edge * z_ + first.z();
    const auto last = [](int size) { return static_cast<float>(size - 1); };
    // u >= 0 where x + cx z >= 0, for any z in front of the camera; each side is moved out by a pixel.
    return (x + (cx_ + 1) * z < 0).all() || (x + (cx_ - last(width) - 1) * z > 0).all() ||
           (y + (cy_ + 1) * z < 0).all() || (y + (cy_ - last(height) - 1) * z > 0).all();
  }

  /// Eight cubes, `edge` voxels long, the lowest at `low` + `offset` along each axis, the others `step` voxels further.
  [[nodiscard]] CubeViews views(const openvdb::Coord& low, float offset, float edge, float step) const {
    const Eigen::Vector3f first = in_camera(low, offset);
    const Corners x = step * x_ + first.x(), y = step * y_ + first.y(), z = step * z_ + first.z();
    CubeViews views;
    views.x0 = views.y0 = Corners::Constant(1e30f);
    views.x1 = views.y1 = Corners::Constant(-1e30f);
    views.near_m = z + edge * least_z_;
    views.far_m = z + edge * greatest_z_;
    for (Eigen::Index corner = 0; corner < 8; ++corner) {
      const Corners per_z = (z + edge * z_[corner]).inverse();
      const Corners px = (x + edge * x_[corner]) * per_z, py = (y + edge * y_[corner]) * per_z;
      views.x0 = views.x0.min(px);
      views.x1 = views.x1.max(px);
      views.y0 = views.y0.min(py);
      views.y1 = views.y1.max(py);
    }
    to_pixels(fx_, cx_, views.x0, views.x1);
    to_pixels(fy_, cy_, views.y0, views.y1);
    return views;
  }

 private:
  using Corners = CubeViews::Numbers;

  [[nodiscard]] Eigen::Vector3f in_camera(const openvdb::Coord& low, float offset) const {
    const Eigen::Vector3d from_eye = Eigen::Vector3d(low.x(), low.y(), low.z()) - eye_;
    return R_ * (from_eye.cast<float>() + Eigen::Vector3f::Constant(offset));
  }
  static void to_pixels(float focal, float centre, Corners& low, Corners& high) {
    const Corners a = focal * low + centre;
    const Corners b = focal * high + centre;
    low = a.min(b) - kSlack;
    high = a.max(b) + kSlack;
  }
  static void to_pixels(float focal, float centre, float& low, float& high) {
    const float a = focal * low + centre;
    const float b = focal * high + centre;
    low = std::min(a, b) - kSlack;
    high = std::max(a, b) + kSlack;
  }

  static constexpr float kSlack = 0.01f;
  Eigen::Vector3d eye_;  ///< voxels
  Eigen::Matrix3f R_;    ///< R_camera_world, and voxels to metres
  Corners x_, y_, z_;    ///< corners of a cube of one voxel, from its lowest corner
  float least_z_, greatest_z_;
  float fx_, fy_, cx_, cy_;
};

}  // namespace scanknit
