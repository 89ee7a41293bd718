// Poses of cameras with OpenGL's axes (x right, y up, the camera looks along -z), as ARKit's and nerfstudio's have.
#pragma once

#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// Our camera is that camera after half a turn about x. Errors: those of pose_from_matrix.
[[nodiscard]] inline Result<Pose> pose_from_opengl(const Eigen::Matrix4d& T_world_opengl) {
  return pose_from_matrix(T_world_opengl * Eigen::Vector4d(1, -1, -1, 1).asDiagonal());
}

[[nodiscard]] inline Eigen::Matrix4d opengl_matrix(const Pose& T_world_camera) {
  return T_world_camera.matrix() * Eigen::Vector4d(1, -1, -1, 1).asDiagonal();
}

}  // namespace scanknit
