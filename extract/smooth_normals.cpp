#include "extract/smooth_normals.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh_area.h"

namespace scanknit {

void fill_missing_normals(Mesh& mesh) {
  constexpr std::size_t kHasNormal = static_cast<std::size_t>(-1);
  std::vector<std::size_t> place;  // among the sums below, for each vertex; stays empty in the usual case
  std::size_t missing = 0;
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    if (!mesh.normals[v].isZero(0)) continue;
    if (place.empty()) place.assign(mesh.normals.size(), kHasNormal);
    place[v] = missing++;
  }
  if (missing == 0) return;

  std::vector<Eigen::Vector3d> sums(missing, Eigen::Vector3d::Zero());
  for (const Triangle& t : mesh.triangles) {
    const auto is_missing = [&](std::uint32_t v) { return place[v] != kHasNormal; };
    if (std::none_of(t.begin(), t.end(), is_missing)) continue;
    const Eigen::Vector3d area = area_vector_m2(mesh, t);
    for (const std::uint32_t v : t) {
      if (is_missing(v)) sums[place[v]] += area;
    }
  }
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    if (place[v] == kHasNormal) continue;
    const Eigen::Vector3d& sum = sums[place[v]];
    const double length = sum.norm();
    mesh.normals[v] = length > 0 ? Eigen::Vector3f((sum / length).cast<float>()) : Eigen::Vector3f::UnitZ();
  }
}

}  // namespace scanknit
