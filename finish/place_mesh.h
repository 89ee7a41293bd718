// Places a mesh: its position and its up direction.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

/// The smallest rotation about the origin that turns `up` (unit) into `wanted_up` (unit).
[[nodiscard]] Pose turn_up(const Eigen::Vector3d& up, const Eigen::Vector3d& wanted_up);

/// The shift that puts the lowest vertex at height 0 along `up` (unit, along an axis), and the centre of the bounding
/// box over the origin.
[[nodiscard]] Pose stand_on_origin(const Mesh& mesh, const Eigen::Vector3d& up);

/// Transforms positions and normals.
void transform_mesh(const Pose& T, Mesh& mesh);

}  // namespace scanknit
