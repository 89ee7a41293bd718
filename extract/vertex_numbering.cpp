#include "extract/vertex_numbering.h"

#include <algorithm>
#include <bit>

#include "extract/bit_count.h"

namespace scanknit {
void BlockRecord::set_edges(const BlockTopology& topology) {
  vertices = topology.vertices();
  edge_vertices = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t x = 0; x < kBlockCells; ++x) {
      rank[axis][x] = static_cast<std::uint16_t>(edge_vertices);
      edge_vertices += count_bits(vertices[axis][x]);
      for (std::uint64_t bits = topology.pinched()[axis][x]; bits != 0; bits &= bits - 1) {
        const int bit = std::countr_zero(bits);
        pinched.push_back(edge_slot(static_cast<int>(axis), static_cast<int>(x), bit / kBlockCells, bit % kBlockCells));
      }
    }
  }
}

VertexIds::VertexIds(const Records& records) : records_(records) {
  for (int neighbour = 0; neighbour < 8; ++neighbour) {
    const BlockRecord* const record = records_[static_cast<std::size_t>(neighbour)];
    if (record == nullptr) continue;
    has_pinched_ = has_pinched_ || !record->pinched.empty();
    for (int axis = 0; axis < 3; ++axis) {
      // An edge that leaves the upper face along its own axis belongs to no cell of this block.
      if (((neighbour >> axis) & 1) == 0) enter(*record, axis, neighbour);
    }
  }
}

/// Of a neighbour's edges only those in this block's closure: its first column, row or layer.
void VertexIds::enter(const BlockRecord& record, int axis, int neighbour) {
  const int at_x = (neighbour & 1) * kBlockCells;
  const int at_y = ((neighbour >> 1) & 1) * kBlockCells;
  const int at_z = (neighbour >> 2) * kBlockCells;
  const std::uint64_t rows = at_y > 0 ? 0xFFu : ~std::uint64_t{0};
  const std::uint64_t shown = at_z > 0 ? rows & 0x0101010101010101u : rows;
  for (int x = 0; x < (at_x > 0 ? 1 : kBlockCells); ++x) {
    const std::uint64_t word = record.vertices[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)];
    std::uint32_t* const ids = ids_.data() + closure_place(axis, x + at_x, at_y, at_z);
    const std::uint32_t first = static_cast<std::uint32_t>(record.first_vertex) +
                                record.rank[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)];
    std::uint32_t next = first;
    for (std::uint64_t bits = word & shown; bits != 0; bits &= bits - 1) {
      const int bit = std::countr_zero(bits);
      if (at_z > 0) next = first + count_bits(word & ((std::uint64_t{1} << bit) - 1));
      ids[bit + (bit >> 3)] = next++;  // eight voxels a row, nine in the closure
    }
  }
}

std::uint32_t VertexIds::of_second_fan(int x, int y, int z, EdgeIndex edge) const {
  const int low = edge_low_corner(edge);
  const int low_x = x + corner_coordinate(low, 0);
  const int low_y = y + corner_coordinate(low, 1);
  const int low_z = z + corner_coordinate(low, 2);
  const int neighbour = (low_x >> 3) | ((low_y >> 3) << 1) | ((low_z >> 3) << 2);
  const BlockRecord& owner = *records_[static_cast<std::size_t>(neighbour)];
  const std::uint16_t slot = edge_slot(edge_axis(edge), low_x & 7, low_y & 7, low_z & 7);
  const auto found = std::lower_bound(owner.pinched.begin(), owner.pinched.end(), slot);
  if (found != owner.pinched.end() && *found == slot)
    return static_cast<std::uint32_t>(owner.first_vertex) + owner.edge_vertices +
           static_cast<std::uint32_t>(found - owner.pinched.begin());
  return of_cell(x, y, z)[kEdgePlace[edge]];
}

}  // namespace scanknit
