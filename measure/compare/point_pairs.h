// Pairs of points that are the same place on a mesh and on its reference.
#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

struct PointPair {
  Eigen::Vector3d on_mesh, on_reference;
};

/// Lines of six numbers, x y z on the mesh and x y z on the reference; spaces or commas between, comments after '#'.
/// Errors (kInput): a line that is none of that, its number in the message.
[[nodiscard]] Result<std::vector<PointPair>> parse_point_pairs(std::string_view text);

/// T_reference_mesh with the least squares (Umeyama 1991, without scale). Errors (kInput): fewer than three pairs, or
/// points that are on one line.
[[nodiscard]] Result<Pose> fit_pairs(const std::vector<PointPair>& pairs);

/// Sixteen numbers, a matrix row by row: rotation and translation, in the unit of `metres` for the latter. Errors
/// (kInput): other numbers, or a matrix that is no rigid motion.
[[nodiscard]] Result<Pose> parse_rigid_matrix(std::string_view text, double metres);

}  // namespace scanknit
