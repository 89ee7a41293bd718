#include "finish/smooth_mesh.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/mesh_area.h"
#include "finish/mesh_edges.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;

// Taubin's lambda and mu: the pass-band ends at 1 / lambda + 1 / mu = 0.113.
constexpr double kForward = 0.5;
constexpr double kBack = -0.53;

/// The neighbours of each vertex; none for vertices of a boundary, or of an edge with more than two sides.
struct Neighbours {
  std::vector<std::size_t> begin;
  std::vector<Index> vertices;
};

Neighbours neighbours_of(const Mesh& mesh) {
  const std::vector<EdgeSide> sides = edge_sides(mesh);
  std::vector<std::uint8_t> is_fixed(mesh.positions_m.size());
  std::vector<std::size_t> count(mesh.positions_m.size() + 1);
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    ++count[edge[0].low + 1];
    ++count[edge[0].high + 1];
    if (edge.size() == 2) return;
    is_fixed[edge[0].low] = 1;
    is_fixed[edge[0].high] = 1;
  });
  for (std::size_t v = 0; v < is_fixed.size(); ++v) {
    if (is_fixed[v] != 0) count[v + 1] = 0;
    count[v + 1] += count[v];
  }
  Neighbours found{count, std::vector<Index>(count.back())};
  const auto put = [&](Index v, Index neighbour) {
    if (is_fixed[v] == 0) found.vertices[count[v]++] = neighbour;
  };
  for_each_edge(sides, [&](std::span<const EdgeSide> edge) {
    put(edge[0].low, edge[0].high);
    put(edge[0].high, edge[0].low);
  });
  return found;
}

}  // namespace

MeshMoved smooth_mesh(std::size_t steps, Mesh& mesh) {
  const Neighbours neighbours = neighbours_of(mesh);
  const std::size_t n = mesh.positions_m.size();
  std::vector<Eigen::Vector3d> now(n), next(n);
  for (std::size_t v = 0; v < n; ++v) now[v] = mesh.positions_m[v].cast<double>();
  for (std::size_t pass = 0; pass < 2 * steps; ++pass) {
    const double step = pass % 2 == 0 ? kForward : kBack;
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t v) {
      const std::size_t begin = neighbours.begin[v];
      const std::size_t end = neighbours.begin[v + 1];
      next[v] = now[v];
      if (begin == end) return;
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      for (std::size_t i = begin; i < end; ++i) mean += now[neighbours.vertices[i]];
      next[v] += step * (mean / static_cast<double>(end - begin) - now[v]);
    });
    now.swap(next);
  }
  MeshMoved moved;
  for (std::size_t v = 0; v < n; ++v) {
    const double distance = (now[v] - mesh.positions_m[v].cast<double>()).norm();
    moved.mean_m += distance / static_cast<double>(n);
    moved.max_m = std::max(moved.max_m, distance);
    mesh.positions_m[v] = now[v].cast<float>();
  }
  if (!mesh.normals.empty()) renew_normals(mesh);
  return moved;
}

void renew_normals(Mesh& mesh) {
  std::vector<Eigen::Vector3d> sum(mesh.positions_m.size(), Eigen::Vector3d::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3d area = area_vector_m2(mesh, t);
    for (const Index vertex : t) sum[vertex] += area;
  }
  mesh.normals.resize(mesh.positions_m.size(), Eigen::Vector3f::Zero());
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const double length = sum[v].norm();
    if (length > 0) mesh.normals[v] = (sum[v] / length).cast<float>();
  }
}

}  // namespace scanknit
