// Placement: from the recording's world to a file's axes and unit, baked into the vertices so that every format agrees.
#pragma once

#include <Eigen/Core>

namespace scanknit {

struct Placement {
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();  ///< determinant +1: triangles keep their winding
  float units_per_metre = 1;

  [[nodiscard]] Eigen::Vector3f position(const Eigen::Vector3f& p_world_m) const {
    return units_per_metre * (rotation * p_world_m);
  }
  [[nodiscard]] Eigen::Vector3f normal(const Eigen::Vector3f& n_world) const { return rotation * n_world; }
};

}  // namespace scanknit
