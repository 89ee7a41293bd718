// TurntableSpace: the space above the disc in which the object turns; everything else is cut away.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"
#include "fusion/turntable/still_scene.h"
#include "fusion/turntable/turntable_axis.h"

namespace scanknit {

/// In the camera's frame, in which it is fixed; also in the object's frame, which is the camera's at angle 0. Heights
/// are measured along `up` from `axis.point`.
struct TurntableSpace {
  TurntableAxis axis;
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();  ///< the axis's direction or its opposite
  double radius_m = 0;
  double foot_m = 0;             ///< the object's lowest height
  std::optional<double> disc_m;  ///< height of the disc, if it was seen

  [[nodiscard]] double height_of(const Eigen::Vector3d& p) const { return up.dot(p - axis.point); }
  [[nodiscard]] double distance_of(const Eigen::Vector3d& p) const {
    return (p - axis.point - up * height_of(p)).norm();
  }
};

[[nodiscard]] TurntableSpace moved(const TurntableSpace& space, const Pose& T_to_from);

/// From the camera's frame to the table's. The origin is where the axis meets the disc, or the height of the object's
/// foot if no disc was seen; -y is up, x is as near to the camera's x as possible. The disc is `beside_m` below the
/// origin's plane: half a voxel is best, so that no sample is on it.
[[nodiscard]] Pose T_table_camera(const TurntableSpace& space, double beside_m);

/// Finds the space of everything that moves in `samples` (depth pictures without what stands still), and the disc below
/// it: the highest plane perpendicular to the axis in the still scene, because the disc's depth does not change when it
/// turns. Something that moves in only a few pictures, like a hand, does not widen the space. Nothing when nothing
/// moves.
[[nodiscard]] std::optional<TurntableSpace> find_space(const std::vector<DepthImage>& samples, const StillScene& still,
                                                       const CameraIntrinsics& camera, const TurntableAxis& axis);

/// Sets depth outside of the space to 0, and depth more than `below_m` below the disc; keeps the disc within the space.
void cut_to_space(DepthImage& depth_m, const CameraIntrinsics& camera, const TurntableSpace& space, double below_m);

}  // namespace scanknit
