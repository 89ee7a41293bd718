// TurntableAxis: the one line about which an object turns before a camera that stands still.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/pose.h"

namespace scanknit {

/// In the camera's frame, where it does not move. `direction` is unit; `point` is any point of the axis.
struct TurntableAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// The turn by `angle_rad` about the axis. With the object's frame that of the camera at angle 0, it is T_object_camera
/// at that angle; between two frames it is T_from_to of the cameras by the difference of their angles.
[[nodiscard]] Pose turn_about(const TurntableAxis& axis, double angle_rad);

/// The angle of the turn about `direction` (unit) that comes nearest to a rotation.
[[nodiscard]] double angle_about(const Eigen::Vector3d& direction, const Eigen::Matrix3d& rotation);

/// The same direction, at most half a turn from 0.
[[nodiscard]] double wrapped(double angle_rad);

/// An axis and one angle a pose.
struct TurntableMotion {
  TurntableAxis axis;
  std::vector<double> angles_rad;  ///< 0 first; neighbours differ by less than half a turn
};

/// The median of the differences of neighbours; 0 of fewer than two.
[[nodiscard]] double usual_step_rad(const TurntableMotion& motion);

/// The axis and angles that come nearest to tracked poses T_object_camera, in their order: the common screw axis of
/// their relative motions, by iteratively reweighted least squares. Nothing when the poses do not turn by 20 degrees.
/// `reach_m`, the distance from the camera at which motions are compared.
[[nodiscard]] std::optional<TurntableMotion> fit_turntable(const std::vector<Pose>& T_object_camera, double reach_m);

/// How far pose i is from the motion, metres: the displacement of a point on the axis at `reach_m` from the camera,
/// plus the rest of the rotation at a tenth of that distance.
[[nodiscard]] std::vector<double> distances_from(const TurntableMotion& motion,
                                                 const std::vector<Pose>& T_object_camera, double reach_m);

}  // namespace scanknit
