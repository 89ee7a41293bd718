// The mapping of a plane to a picture.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace scanknit {

/// H with pixel ~ H (x, y, 1) that fits at least four pairs best in the algebraic sense, both sides normalised (Hartley
/// 1997, "In defense of the eight-point algorithm"). Of length 1; meaningless for points on a line.
[[nodiscard]] Eigen::Matrix3d fit_homography(const std::vector<Eigen::Vector2d>& plane,
                                             const std::vector<Eigen::Vector2d>& pixels);

[[nodiscard]] inline Eigen::Vector2d apply(const Eigen::Matrix3d& H, const Eigen::Vector2d& point) {
  return (H * point.homogeneous()).hnormalized();
}

}  // namespace scanknit
