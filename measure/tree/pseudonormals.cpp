#include "measure/tree/pseudonormals.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numeric>

#include "core/check.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

std::array<Vector3d, 3> corners_of(const Mesh& mesh, const Triangle& t) {
  return {mesh.positions_m[t[0]].cast<double>(), mesh.positions_m[t[1]].cast<double>(),
          mesh.positions_m[t[2]].cast<double>()};
}

}  // namespace

Pseudonormals::Pseudonormals(const Mesh& mesh)
    : mesh_(mesh), first_(mesh.positions_m.size() + 1, 0), triangles_(3 * mesh.triangles.size()) {
  SCANKNIT_CHECK(mesh.triangles.size() <= UINT32_MAX / 3);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) ++first_[v + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t v : mesh.triangles[i]) triangles_[next[v]++] = i;
  }
}

Vector3d Pseudonormals::face(std::uint32_t triangle) const {
  const auto [a, b, c] = corners_of(mesh_, mesh_.triangles[triangle]);
  return (b - a).cross(c - a).stableNormalized();
}

Vector3d Pseudonormals::at(std::uint32_t triangle, TriangleFeature feature) const {
  const Triangle& t = mesh_.triangles[triangle];
  switch (feature) {
    case TriangleFeature::kVertex0: return at_vertex(t[0]);
    case TriangleFeature::kVertex1: return at_vertex(t[1]);
    case TriangleFeature::kVertex2: return at_vertex(t[2]);
    case TriangleFeature::kEdge01: return at_edge(t[0], t[1]);
    case TriangleFeature::kEdge12: return at_edge(t[1], t[2]);
    case TriangleFeature::kEdge20: return at_edge(t[2], t[0]);
    case TriangleFeature::kFace: break;
  }
  return face(triangle);
}

std::span<const std::uint32_t> Pseudonormals::triangles_at(std::uint32_t vertex) const {
  return std::span(triangles_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
}

Vector3d Pseudonormals::at_edge(std::uint32_t from, std::uint32_t to) const {
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t i : triangles_at(from)) {
    const Triangle& t = mesh_.triangles[i];
    if (t[0] == to || t[1] == to || t[2] == to) sum += face(i);
  }
  return sum;
}

Vector3d Pseudonormals::at_vertex(std::uint32_t vertex) const {
  Vector3d sum = Vector3d::Zero();
  for (const std::uint32_t i : triangles_at(vertex)) {
    const Triangle& t = mesh_.triangles[i];
    const auto p = corners_of(mesh_, t);
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] != vertex) continue;
      const Vector3d to_next = p[(k + 1) % 3] - p[k];
      const Vector3d to_last = p[(k + 2) % 3] - p[k];
      sum += std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last)) * face(i);
      break;
    }
  }
  return sum;
}

EdgeCounts Pseudonormals::count_edges() const {
  /// What the edge of a triangle from its k-th corner adds: each edge is counted at the first triangle that has it.
  const auto add_edge = [this](std::uint32_t triangle, std::size_t k, EdgeCounts& counts) {
    const std::uint32_t from = mesh_.triangles[triangle][k], to = mesh_.triangles[triangle][(k + 1) % 3];
    std::size_t same_way = 0, other_way = 0;
    for (const std::uint32_t i : triangles_at(from)) {
      const Triangle& t = mesh_.triangles[i];
      for (std::size_t j = 0; j < 3; ++j) {
        const std::uint32_t a = t[j], b = t[(j + 1) % 3];
        const bool is_same = a == from && b == to, is_other = a == to && b == from;
        if ((is_same || is_other) && (i < triangle || (i == triangle && j < k))) return;
        same_way += is_same ? 1 : 0;
        other_way += is_other ? 1 : 0;
      }
    }
    if (same_way + other_way == 1) ++counts.border;
    if (same_way + other_way > 2 || same_way == 2 || other_way == 2) ++counts.tangled;
  };
  return tbb::parallel_reduce(
      tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(mesh_.triangles.size()), 4096), EdgeCounts{},
      [&](const tbb::blocked_range<std::uint32_t>& range, EdgeCounts counts) {
        for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
          for (std::size_t k = 0; k < 3; ++k) add_edge(i, k, counts);
        }
        return counts;
      },
      [](const EdgeCounts& a, const EdgeCounts& b) {
        return EdgeCounts{a.border + b.border, a.tangled + b.tangled};
      });
}

}  // namespace scanknit
