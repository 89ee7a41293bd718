#include "measure/solid/thickness.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/mesh/mesh_area.h"
#include "measure/area_points.h"
#include "measure/mesh_unit.h"

namespace scanknit {

WallThickness measure_thickness(const Mesh& mesh, const TriangleBvh& tree, bool is_inside_out,
                                std::optional<double> thin_m, std::size_t points) {
  constexpr double kBelowSurface = 1e-6;  // of the mesh's size: from here the ray does not meet its own triangle
  const double size_m = diagonal_m(mesh), below_m = kBelowSurface * size_m;
  const auto normal_of = [&](std::uint32_t triangle) -> Eigen::Vector3d {
    const Eigen::Vector3d normal = area_vector_m2(mesh, mesh.triangles[triangle]).stableNormalized();
    return is_inside_out ? Eigen::Vector3d(-normal) : normal;
  };
  const std::vector<AreaPoint> samples = spread_over_area(mesh, points);
  std::vector<double> thickness_m(samples.size(), std::numeric_limits<double>::quiet_NaN());
  tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
    const Eigen::Vector3d inwards = -normal_of(samples[i].triangle);
    const Ray ray{samples[i].position_m + below_m * inwards, inwards};
    const auto hit = tree.intersect(ray, size_m);
    if (hit && normal_of(hit->triangle).dot(inwards) > 0) thickness_m[i] = hit->t_m + below_m;
  });

  WallThickness walls;
  walls.points = samples.size();
  std::vector<double> known;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (std::isnan(thickness_m[i])) continue;
    if (known.empty() || thickness_m[i] < walls.min_m) {
      walls.min_m = thickness_m[i];
      walls.thinnest_m = samples[i].position_m;
    }
    known.push_back(thickness_m[i]);
  }
  if (known.empty()) return walls;
  std::sort(known.begin(), known.end());
  const auto n = static_cast<double>(known.size());
  const auto quantile = [&](double q) { return known[static_cast<std::size_t>(q * (n - 1))]; };
  walls.share_measured = n / static_cast<double>(samples.size());
  walls.p01_m = quantile(0.01);
  walls.p05_m = quantile(0.05);
  walls.median_m = quantile(0.5);
  walls.max_m = known.back();
  if (thin_m) {
    const auto thin = std::lower_bound(known.begin(), known.end(), *thin_m) - known.begin();
    walls.share_thin = static_cast<double>(thin) / static_cast<double>(samples.size());
  }
  return walls;
}

}  // namespace scanknit
