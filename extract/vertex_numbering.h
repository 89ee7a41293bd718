// The mesh's index of every vertex, without a hash map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "extract/blocks/block_topology.h"
#include "extract/cell/cell_table.h"

namespace scanknit {

/// What the counting pass stores for a block that meets the surface. Its vertices are numbered in this order: those on
/// its grid edges by axis, x, y, z; the second vertices of its pinched edges in the same order; interior vertices by
/// cell.
struct BlockRecord {
  std::size_t block = 0;  ///< in the source's list
  EdgeBits vertices;
  std::array<std::array<std::uint16_t, kBlockCells>, 3> rank;  ///< vertices before each word of `vertices`
  std::vector<std::uint16_t> pinched;                          ///< edge_slot() of each pinched edge, ascending
  std::vector<CellEntry> resolved;                             ///< entries of the cells with needs_values, in order
  std::uint32_t edge_vertices = 0;
  std::uint32_t interior_vertices = 0;
  std::uint32_t triangles = 0;
  std::size_t first_vertex = 0;
  std::size_t first_triangle = 0;

  void set_edges(const BlockTopology& topology);
  [[nodiscard]] std::uint32_t vertex_count() const {
    return edge_vertices + static_cast<std::uint32_t>(pinched.size()) + interior_vertices;
  }
  [[nodiscard]] std::size_t first_interior_vertex() const { return first_vertex + vertex_count() - interior_vertices; }
};

/// The number of a grid edge in its block.
[[nodiscard]] constexpr std::uint16_t edge_slot(int axis, int x, int y, int z) {
  return static_cast<std::uint16_t>(((axis * kBlockCells + x) * kBlockCells + y) * kBlockCells + z);
}

/// The grid edges whose low end is in a block's closure, 9^3 for each axis, have indices in an array.
inline constexpr int kClosureSide = kBlockCells + 1;
[[nodiscard]] constexpr int closure_place(int axis, int x, int y, int z) {
  return ((axis * kClosureSide + x) * kClosureSide + y) * kClosureSide + z;
}
/// The index of a cell's edge minus that of the edge (0, x, y, z) of the cell at (x, y, z).
inline constexpr auto kEdgePlace = [] {
  std::array<int, kEdges> places{};
  for (int edge = 0; edge < kEdges; ++edge) {
    const int low = edge_low_corner(edge);
    places[static_cast<std::size_t>(edge)] =
        closure_place(edge_axis(edge), corner_coordinate(low, 0), corner_coordinate(low, 1), corner_coordinate(low, 2));
  }
  return places;
}();

/// The indices of all vertices on grid edges that the cells of one block use: its own, and those of its neighbours
/// towards +x, +y, +z, which own the grid edges that start in the block's upper faces.
class VertexIds {
 public:
  /// The block and its seven neighbours; the index has one bit each for +x, +y, +z. Null if there is no record.
  using Records = std::array<const BlockRecord*, 8>;
  explicit VertexIds(const Records& records);

  /// The vertices of the cell at (x, y, z): that on edge e, which exists when the cell is active and the edge is
  /// crossed, is at kEdgePlace[e]; unless has_pinched().
  [[nodiscard]] const std::uint32_t* of_cell(int x, int y, int z) const {
    return ids_.data() + closure_place(0, x, y, z);
  }

  /// True if one of the blocks has pinched edges; only of() distinguishes their two vertices.
  [[nodiscard]] bool has_pinched() const { return has_pinched_; }
  [[nodiscard]] std::uint32_t of(int x, int y, int z, EdgeIndex edge) const {
    return has_pinched_ && is_second_fan(edge) ? of_second_fan(x, y, z, edge) : of_cell(x, y, z)[kEdgePlace[edge]];
  }

 private:
  [[nodiscard]] std::uint32_t of_second_fan(int x, int y, int z, EdgeIndex edge) const;
  void enter(const BlockRecord& record, int axis, int neighbour);

  Records records_;
  bool has_pinched_ = false;
  std::array<std::uint32_t, std::size_t{3} * kClosureSide * kClosureSide * kClosureSide>
      ids_;  // set only where there is a vertex
};

}  // namespace scanknit
