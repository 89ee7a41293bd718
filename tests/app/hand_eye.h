// Hand-eye calibration: where a camera sits on a robot's arm, from the poses of both.
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace scanknit {

using Poses = std::vector<Eigen::Isometry3d>;

/// T_hand_camera, from poses of the hand (in the robot's base) and of the camera (in any world) at the same moments:
/// A X = X B of all pairs of moments, by least squares; the rotation as in Park & Martin 1994, "Robot sensor
/// calibration: solving AX = XB on the Euclidean group". The hand must turn about two axes.
[[nodiscard]] Eigen::Isometry3d hand_eye(const Poses& T_base_hand, const Poses& T_world_camera);

}  // namespace scanknit
