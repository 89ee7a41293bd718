// The rotation between two directions.
#pragma once

#include <Eigen/Geometry>

namespace scanknit {

/// The shortest rotation that turns `from` to the direction of `to`: Eigen's FromTwoVectors(), which takes the compiler
/// ten seconds wherever it is called.
[[nodiscard]] Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace scanknit
