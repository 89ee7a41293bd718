// CameraIntrinsics: the pinhole camera. Camera frame: x right, y down, z forward; pixel centres are integers.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace scanknit {

/// A pinhole camera without distortion (readers undistort). Focal lengths and principal point in pixels.
/// Valid: width, height >= 1; fx, fy finite and non-zero; cx, cy finite. A negative fy means that the camera's y axis
/// points up in the recording's convention (ICL-NUIM): the world is then the recording's own, mirrored one.
struct CameraIntrinsics {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;

  [[nodiscard]] bool is_valid() const {
    return width >= 1 && height >= 1 && std::isfinite(fx) && std::isfinite(fy) && fx != 0 && fy != 0 &&
           std::isfinite(cx) && std::isfinite(cy);
  }

  /// Pixel coordinates of a camera-frame point with z > 0.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& p_camera) const {
    return {fx * p_camera.x() / p_camera.z() + cx, fy * p_camera.y() / p_camera.z() + cy};
  }

  /// The camera-frame point that pixel (u, v) sees at z-depth `depth_m`.
  [[nodiscard]] Eigen::Vector3d unproject(double u, double v, double depth_m) const {
    return {(u - cx) / fx * depth_m, (v - cy) / fy * depth_m, depth_m};
  }

  /// The same camera for a picture resized to `new_width` x `new_height`; pixel centres stay integers.
  [[nodiscard]] CameraIntrinsics resized(int new_width, int new_height) const {
    const double sx = static_cast<double>(new_width) / width;
    const double sy = static_cast<double>(new_height) / height;
    return {new_width, new_height, fx * sx, fy * sy, (cx + 0.5) * sx - 0.5, (cy + 0.5) * sy - 0.5};
  }

  friend bool operator==(const CameraIntrinsics&, const CameraIntrinsics&) = default;
};

}  // namespace scanknit
