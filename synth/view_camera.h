// ViewCamera: which ray each pixel of a rendered picture sees: lens, and a pose for each band of rows.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"

namespace scanknit {

/// Radial terms of a lens (Brown 1966), in OpenCV's order: x' = x (1 + k1 r^2 + k2 r^4), where x is the ideal and x'
/// the seen position at depth 1.
struct RadialLens {
  double k1 = 0, k2 = 0;
  friend bool operator==(const RadialLens&, const RadialLens&) = default;
};

/// Where a picture shows a point.
struct Sighting {
  Eigen::Vector3d p_camera;
  Eigen::Vector2d pixel;
  Eigen::Matrix3d R_camera_world;
};

class ViewCamera {
 public:
  /// An ideal pinhole that sees all rows at once.
  ViewCamera(const CameraIntrinsics& intrinsics, const Pose& T_world_camera);
  /// A lens, and a shutter that rolls: the rows are divided into as many bands of equal height as there are poses, the
  /// first band at the top. At least one pose, and at most one for each row.
  ViewCamera(const CameraIntrinsics& intrinsics, const RadialLens& lens, std::vector<Pose> band_poses);

  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }
  [[nodiscard]] const Pose& T_world_camera(int row) const { return poses_[band_of(row)]; }

  /// The point at depth 1, in the camera's frame, that the pixel sees.
  [[nodiscard]] Eigen::Vector3d through(int x, int y) const;

  /// Nothing if the point is behind the camera. The pixel may be outside of the picture.
  [[nodiscard]] std::optional<Sighting> see(const Eigen::Vector3d& p_world) const;

 private:
  [[nodiscard]] std::size_t band_of(double row) const;
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector3d& p_camera) const;

  CameraIntrinsics intrinsics_;
  RadialLens lens_;
  std::vector<Pose> poses_;
  std::vector<Pose> inverses_;
};

}  // namespace scanknit
