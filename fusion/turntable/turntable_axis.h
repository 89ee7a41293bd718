// TurntableAxis: the line about which an object turns in front of a fixed camera.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/pose.h"

namespace scanknit {

/// In the camera's frame, in which it is fixed. `direction` is unit; `point` is any point of the axis.
struct TurntableAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// The rotation by `angle_rad` about the axis. If the object's frame is the camera's at angle 0, this is
/// T_object_camera at that angle; with the difference of two frames' angles it is T_from_to of their cameras.
[[nodiscard]] Pose turn_about(const TurntableAxis& axis, double angle_rad);

/// The angle of the rotation about `direction` (unit) that is nearest to a given rotation.
[[nodiscard]] double angle_about(const Eigen::Vector3d& direction, const Eigen::Matrix3d& rotation);

/// The equivalent angle that is at most half a turn from 0.
[[nodiscard]] double wrapped(double angle_rad);

/// An axis, and one angle for each pose.
struct TurntableMotion {
  TurntableAxis axis;
  std::vector<double> angles_rad;  ///< 0 first; neighbours differ by less than half a turn
};

/// The median difference of successive angles; 0 for fewer than two.
[[nodiscard]] double usual_step_rad(const TurntableMotion& motion);

/// Fits axis and angles to tracked poses T_object_camera, in their order: the common screw axis of their relative
/// motions, by iteratively reweighted least squares. Nothing when the poses turn by less than 20 degrees. `reach_m`:
/// the distance from the camera at which motions are compared.
[[nodiscard]] std::optional<TurntableMotion> fit_turntable(const std::vector<Pose>& T_object_camera, double reach_m);

/// The distance of pose i from the motion, metres: the displacement of a point on the axis at `reach_m` from the
/// camera, plus the rest of the rotation at a tenth of that distance.
[[nodiscard]] std::vector<double> distances_from(const TurntableMotion& motion,
                                                 const std::vector<Pose>& T_object_camera, double reach_m);

}  // namespace scanknit
