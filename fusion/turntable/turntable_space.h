// TurntableSpace: the room above the disc of a turntable in which its object turns; all else is cut away.
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

/// In the camera's frame, where it does not move; also in the object's, which is the camera's at angle 0. Heights are
/// along `up` from `axis.point`.
struct TurntableSpace {
  TurntableAxis axis;
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();  ///< the axis's direction or its opposite
  double radius_m = 0;
  double foot_m = 0;             ///< the object's lowest height
  std::optional<double> disc_m;  ///< height of the disc that carries the object, when it is seen

  [[nodiscard]] double height_of(const Eigen::Vector3d& p) const { return up.dot(p - axis.point); }
  [[nodiscard]] double distance_of(const Eigen::Vector3d& p) const {
    return (p - axis.point - up * height_of(p)).norm();
  }
};

[[nodiscard]] TurntableSpace moved(const TurntableSpace& space, const Pose& T_to_from);

/// From the camera's frame to the table's: the origin where the axis meets the disc, or the object's foot where none is
/// seen; -y is up, x as near to the camera's as can be. The disc lies `beside_m` under the origin's plane: half a voxel
/// is best, so that no sample is on it.
[[nodiscard]] Pose T_table_camera(const TurntableSpace& space, double beside_m);

/// The space of what moves in `samples` (depth pictures without what stands still), and below it the disc: the highest
/// plane across the axis among what stands still. The disc turns, too, but its depth does not change. What moves in few
/// of the pictures, like a hand, does not widen the space. Nothing when nothing moves.
[[nodiscard]] std::optional<TurntableSpace> find_space(const std::vector<DepthImage>& samples, const StillScene& still,
                                                       const CameraIntrinsics& camera, const TurntableAxis& axis);

/// Depth outside of the space becomes 0; the disc within it stays, what is more than `below_m` under it does not.
void cut_to_space(DepthImage& depth_m, const CameraIntrinsics& camera, const TurntableSpace& space, double below_m);

}  // namespace scanknit
