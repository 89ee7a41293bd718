#include "finish/mesh_edges.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "core/mesh/unused_vertices.h"

namespace scanknit {
namespace {

using Index = std::uint32_t;
constexpr Index kNone = std::numeric_limits<Index>::max();

void append_copy(Index vertex, Mesh& mesh) {
  mesh.positions_m.push_back(Eigen::Vector3f(mesh.positions_m[vertex]));
  if (!mesh.normals.empty()) mesh.normals.push_back(Eigen::Vector3f(mesh.normals[vertex]));
  if (!mesh.colours.empty()) mesh.colours.push_back(Rgb8(mesh.colours[vertex]));
}

std::size_t corner_at(const Triangle& triangle, Index vertex) {
  return triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
}

/// Sets of triangle corners (three for each triangle), one set for each fan.
DisjointSets fans_of(const Mesh& mesh) {
  DisjointSets corners(3 * mesh.triangles.size());
  for_each_edge(edge_sides(mesh), [&](std::span<const EdgeSide> sides) {
    if (sides.size() != 2) return;
    for (const Index vertex : {sides[0].low, sides[0].high}) {
      const auto corner = [&](const EdgeSide& side) {
        return static_cast<Index>(3 * side.triangle + corner_at(mesh.triangles[side.triangle], vertex));
      };
      corners.join(corner(sides[0]), corner(sides[1]));
    }
  });
  return corners;
}

}  // namespace

std::vector<EdgeSide> edge_sides(const Mesh& mesh) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]);
      sides.push_back({low, high, static_cast<Index>(t)});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const EdgeSide& a, const EdgeSide& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

void keep_triangles(const std::vector<std::uint8_t>& keeps, Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < keeps.size(); ++t) {
    if (keeps[t] != 0) mesh.triangles[kept++] = mesh.triangles[t];
  }
  mesh.triangles.resize(kept);
  drop_unused_vertices(mesh);
}

std::vector<std::uint8_t> non_manifold_vertices(const Mesh& mesh) {
  std::vector<std::uint8_t> is_bad(mesh.positions_m.size());
  const auto runs_up = [&](const EdgeSide& side) {
    const Triangle& t = mesh.triangles[side.triangle];
    return t[(corner_at(t, side.low) + 1) % 3] == side.high;
  };
  for_each_edge(edge_sides(mesh), [&](std::span<const EdgeSide> sides) {
    if (sides.size() == 1 || (sides.size() == 2 && runs_up(sides[0]) != runs_up(sides[1]))) return;
    is_bad[sides[0].low] = 1;
    is_bad[sides[0].high] = 1;
  });
  DisjointSets fans = fans_of(mesh);
  std::vector<Index> first(mesh.positions_m.size(), kNone);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index vertex = mesh.triangles[t][i];
      const Index fan = fans.root(static_cast<Index>(3 * t + i));
      if (first[vertex] == kNone) first[vertex] = fan;
      if (first[vertex] != fan) is_bad[vertex] = 1;
    }
  }
  return is_bad;
}

void split_fans(Mesh& mesh) {
  DisjointSets corners = fans_of(mesh);
  std::vector<Index> owner(mesh.positions_m.size(), kNone);        // the fan that keeps the vertex
  std::vector<Index> vertex_of(3 * mesh.triangles.size(), kNone);  // the vertex of each other fan, indexed by its root
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      Index& vertex = mesh.triangles[t][i];
      const Index fan = corners.root(static_cast<Index>(3 * t + i));
      if (owner[vertex] == kNone) owner[vertex] = fan;
      if (owner[vertex] == fan) continue;
      if (vertex_of[fan] == kNone) {
        vertex_of[fan] = static_cast<Index>(mesh.positions_m.size());
        append_copy(vertex, mesh);
      }
      vertex = vertex_of[fan];
    }
  }
}

}  // namespace scanknit
