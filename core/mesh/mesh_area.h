// The area of a mesh.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/mesh.h"

namespace scanknit {

/// The triangle's unit normal times its area.
[[nodiscard]] inline Eigen::Vector3d area_vector_m2(const Mesh& mesh, const Triangle& t) {
  const auto at = [&](std::size_t i) { return mesh.positions_m[t[i]].cast<double>().eval(); };
  return (at(1) - at(0)).cross(at(2) - at(0)) / 2;
}

/// The area of all triangles, summed in their order.
[[nodiscard]] inline double area_m2(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) sum += area_vector_m2(mesh, t).norm();
  return sum;
}

}  // namespace scanknit
