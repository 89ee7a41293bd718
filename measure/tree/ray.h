// Ray: a half-line.
#pragma once

#include <Eigen/Core>

namespace scanknit {

/// `direction` is a unit vector.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;

  [[nodiscard]] Eigen::Vector3d at(double t_m) const { return origin + t_m * direction; }
};

}  // namespace scanknit
