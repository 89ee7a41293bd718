// Angles, and the rotation between two directions.
#pragma once

#include <Eigen/Geometry>

#include <numbers>

namespace scanknit {

inline constexpr double kFullTurn = 2 * std::numbers::pi;  // rad
inline constexpr double kDegree = std::numbers::pi / 180;  // rad

/// The shortest rotation that turns `from` to the direction of `to`: Eigen's FromTwoVectors(), which takes the compiler
/// ten seconds wherever it is called.
[[nodiscard]] Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace scanknit
