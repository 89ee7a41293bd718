// VertexNumbering: the mesh's index of every vertex, without a hash map.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "extract/block_topology.h"

namespace scanknit {

/// What the counting pass keeps of a block. Its vertices are numbered in this order: those on its grid edges by axis,
/// x, y, z; the second vertices of its pinched edges in the same order; interior vertices by cell.
struct BlockRecord {
  EdgeBits vertices{};
  std::array<std::array<std::uint16_t, kBlockCells>, 3> rank{};  ///< vertices before each word of `vertices`
  std::vector<std::uint16_t> pinched;                            ///< slots (edge_slot) in ascending order
  std::uint32_t edge_vertices = 0;
  std::uint32_t interior_vertices = 0;
  std::uint32_t triangles = 0;
  std::size_t first_vertex = 0;
  std::size_t first_triangle = 0;

  void set_edges(const BlockTopology& topology);
  [[nodiscard]] std::size_t vertex_count() const { return edge_vertices + pinched.size() + interior_vertices; }
  [[nodiscard]] std::size_t first_interior_vertex() const { return first_vertex + edge_vertices + pinched.size(); }
  [[nodiscard]] std::size_t index_of(int axis, int x, int y, int z, bool second_fan) const;
};

/// Sets first_vertex and first_triangle of every record, in order. Returns the numbers of vertices and triangles.
struct MeshSize {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};
MeshSize number_vertices(std::span<BlockRecord> records);

/// The records that the cells of one block refer to: its own and those of its seven neighbours towards +x, +y, +z,
/// which own the grid edges that start in the block's upper faces.
class VertexNumbering {
 public:
  /// `origins` sorted by is_before, one for each record.
  VertexNumbering(std::span<const Eigen::Vector3i> origins, std::span<const BlockRecord> records, std::size_t block);

  /// The vertex on edge `edge` of the cell at (x, y, z); it exists when the cell is active and the edge is crossed.
  [[nodiscard]] std::size_t index_of(int x, int y, int z, int edge) const;

 private:
  std::array<const BlockRecord*, 8> records_{};  ///< by a bit each for +x, +y, +z
};

}  // namespace scanknit
