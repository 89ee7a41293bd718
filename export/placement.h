// Placement: from a mesh's axes and unit to a file's; applied to the vertices, so that all formats agree.
#pragma once

#include <Eigen/Core>
#include <string>

namespace scanknit {

struct Placement {
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();  ///< determinant +1: triangles keep their winding
  float scale = 1;                                         ///< file units per unit of the mesh
  std::string unit = "metres";                             ///< of the file, for messages

  [[nodiscard]] Eigen::Vector3f position(const Eigen::Vector3f& p_world) const { return scale * (rotation * p_world); }
  [[nodiscard]] Eigen::Vector3f normal(const Eigen::Vector3f& n_world) const { return rotation * n_world; }
};

}  // namespace scanknit
