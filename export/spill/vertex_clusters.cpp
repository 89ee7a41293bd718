#include "export/spill/vertex_clusters.h"

#include <algorithm>
#include <limits>

#include "core/check.h"

namespace scanknit {

VertexClusters::VertexClusters(const Eigen::AlignedBox3f& bounds, int cubes)
    : corner_(bounds.min()),
      cubes_per_metre_(static_cast<float>(cubes) /
                       std::max(bounds.sizes().maxCoeff(), std::numeric_limits<float>::min())) {
  SCANKNIT_CHECK(cubes > 0 && !bounds.isEmpty());
}

std::uint64_t VertexClusters::cube_of(const Eigen::Vector3f& position) const {
  constexpr int kBits = 21;  // for each axis
  constexpr float kLast = (1 << kBits) - 1;
  std::uint64_t cube = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float place = std::clamp((position[axis] - corner_[axis]) * cubes_per_metre_, 0.0f, kLast);
    cube = cube << kBits | static_cast<std::uint64_t>(place);
  }
  return cube;
}

void VertexClusters::add_vertex(const Eigen::Vector3f& position, const Eigen::Vector3f& normal) {
  const auto next = static_cast<std::uint32_t>(clusters_.size());
  const auto [place, is_new] = index_of_cube_.try_emplace(cube_of(position), next);
  if (is_new) clusters_.emplace_back();
  Cluster& cluster = clusters_[place->second];
  cluster.sum_from_corner += position - corner_;
  cluster.normal_sum += normal;
  ++cluster.vertices;
}

void VertexClusters::add_triangle(const std::array<Eigen::Vector3f, 3>& corners) {
  const std::uint64_t a = cube_of(corners[0]), b = cube_of(corners[1]), c = cube_of(corners[2]);
  if (a == b || b == c || c == a) return;
  Triangle triangle(index_of_cube_.at(a), index_of_cube_.at(b), index_of_cube_.at(c));
  std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
  triangles_.push_back(triangle);
}

Mesh VertexClusters::take() {
  Mesh mesh;
  for (const Cluster& cluster : clusters_) {
    mesh.positions_m.emplace_back(corner_ + cluster.sum_from_corner / cluster.vertices);
    const float length = cluster.normal_sum.norm();
    mesh.normals.emplace_back(length > 0 ? Eigen::Vector3f(cluster.normal_sum / length) : Eigen::Vector3f::UnitZ());
  }
  std::sort(triangles_.begin(), triangles_.end());
  triangles_.erase(std::unique(triangles_.begin(), triangles_.end()), triangles_.end());
  mesh.triangles = std::move(triangles_);
  return mesh;
}

}  // namespace scanknit
