#include "measure/area_points.h"

#include <algorithm>
#include <cmath>

#include "core/counter_random.h"
#include "core/mesh/mesh_area.h"

namespace scanknit {

using Eigen::Vector3d;

std::vector<AreaPoint> spread_over_area(const Mesh& mesh, std::size_t count) {
  std::vector<double> area_up_to;
  area_up_to.reserve(mesh.triangles.size());
  double total = 0;
  const auto at = [&](std::uint32_t v) -> Vector3d { return mesh.positions_m[v].cast<double>(); };
  for (const Triangle& t : mesh.triangles) {
    total += area_vector_m2(mesh, t).norm();
    area_up_to.push_back(total);
  }
  std::vector<AreaPoint> points;
  if (!(total > 0)) return points;
  points.reserve(count);
  std::size_t triangle = 0;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(0, 0, i);
    const double target = (static_cast<double>(i) + random.uniform()) / static_cast<double>(count) * total;
    while (triangle + 1 < area_up_to.size() && area_up_to[triangle] <= target) ++triangle;
    const Triangle& t = mesh.triangles[triangle];
    // Uniform in the triangle: the square root corrects for the small area near the first corner.
    const double u = std::sqrt(random.uniform());
    const double v = random.uniform();
    points.push_back(
        {(1 - u) * at(t[0]) + u * (1 - v) * at(t[1]) + u * v * at(t[2]), static_cast<std::uint32_t>(triangle)});
  }
  return points;
}

std::vector<Vector3d> positions_of(const std::vector<AreaPoint>& points) {
  std::vector<Vector3d> positions;
  positions.reserve(points.size());
  for (const AreaPoint& point : points) positions.push_back(point.position_m);
  return positions;
}

Result<void> check_measurable(const Mesh& mesh) {
  const auto refuse = [](const char* what) { return Error{ErrorCode::kMesh, what}; };
  if (mesh.empty()) return refuse("the mesh has no triangles");
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    if (!p.allFinite()) return refuse("a vertex of the mesh is not finite");
  }
  double area_m2 = 0;
  for (const Triangle& t : mesh.triangles) {
    if (std::max({t[0], t[1], t[2]}) >= mesh.positions_m.size()) return refuse("a triangle's index is out of range");
    area_m2 += area_vector_m2(mesh, t).norm();
  }
  if (!(area_m2 > 0 && std::isfinite(area_m2))) return refuse("the mesh has no area");
  return {};
}

}  // namespace scanknit
