#include "export/mesh/mesh_builder.h"

#include <fmt/format.h>

#include <algorithm>

namespace scanknit {

Result<void> add_polygon(std::span<const std::uint32_t> corners, const Limits& limits, Mesh& mesh) {
  if (corners.size() < 3) return {};
  if (corners.size() - 2 > limits.max_mesh_triangles - std::min(mesh.triangles.size(), limits.max_mesh_triangles)) {
    return input_error(fmt::format("more triangles than the limit of {}", limits.max_mesh_triangles));
  }
  for (std::size_t i = 2; i < corners.size(); ++i) mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  return {};
}

Result<Mesh> finish_mesh(Mesh mesh) {
  const std::size_t n = mesh.positions_m.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    const std::uint32_t largest = std::max({t[0], t[1], t[2]});
    if (largest >= n) return input_error(fmt::format("a face names vertex {} of the {} there are", largest, n));
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!mesh.positions_m[i].allFinite()) return input_error(fmt::format("the position of vertex {} is not finite", i));
  }
  for (Eigen::Vector3f& normal : mesh.normals) {
    if (!normal.allFinite()) normal.setZero();
  }
  return mesh;
}

}  // namespace scanknit
