// The edges of a mesh, and sets of its triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh.h"
#include "core/mesh/disjoint_sets.h"

namespace scanknit {

/// One triangle's side of an edge.
struct EdgeSide {
  std::uint32_t low, high;  ///< vertices
  std::uint32_t triangle;
};

/// The sides of all edges, sorted by vertices, then by triangle: the sides of an edge follow one another.
[[nodiscard]] std::vector<EdgeSide> edge_sides(const Mesh& mesh);

/// Calls visit(span of the sides of one edge) for every edge.
template <typename Visit>
void for_each_edge(const std::vector<EdgeSide>& sides, const Visit& visit) {
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
    visit(std::span(sides).subspan(begin, end - begin));
    begin = end;
  }
}

/// Keeps the triangles marked with 1, in their order, and the vertices that they use.
void keep_triangles(const std::vector<std::uint8_t>& keeps, Mesh& mesh);

/// 1 for the vertices of edges with more than two sides or with two sides of the same direction, and for vertices with
/// several fans.
[[nodiscard]] std::vector<std::uint8_t> non_manifold_vertices(const Mesh& mesh);

/// Gives each fan of triangles at a vertex its own vertex.
void split_fans(Mesh& mesh);

}  // namespace scanknit
