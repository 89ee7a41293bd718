#include "extract/vertex_numbering.h"

#include <algorithm>
#include <bit>

#include "extract/blocks/bit_count.h"

namespace scanknit {
namespace {

/// For a row of eight bits, how many are set before each, and in all.
struct RowOrder {
  std::array<std::uint16_t, kBlockCells> before{};
  std::uint16_t all = 0;
};
constexpr auto kRowOrders = [] {
  std::array<RowOrder, 256> orders{};
  for (unsigned row = 0; row < orders.size(); ++row) {
    for (unsigned z = 0; z < kBlockCells; ++z) {
      orders[row].before[z] = orders[row].all;
      orders[row].all = static_cast<std::uint16_t>(orders[row].all + ((row >> z) & 1));
    }
  }
  return orders;
}();

}  // namespace

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

/// Of a neighbour's edges only those in this block's closure: its first column, row or layer. Edges without a vertex
/// get a number too, that nothing asks for: it is faster to write whole rows.
void VertexIds::enter(const BlockRecord& record, int axis, int neighbour) {
  const int at_x = (neighbour & 1) * kBlockCells;
  const int at_y = ((neighbour >> 1) & 1) * kBlockCells;
  const int at_z = (neighbour >> 2) * kBlockCells;
  for (int x = 0; x < (at_x > 0 ? 1 : kBlockCells); ++x) {
    std::uint64_t word = record.vertices[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)];
    if (word == 0) continue;
    std::uint32_t* ids = ids_.data() + closure_place(axis, x + at_x, at_y, at_z);
    auto next = static_cast<std::uint32_t>(record.first_vertex) +
                record.rank[static_cast<std::size_t>(axis)][static_cast<std::size_t>(x)];
    for (int y = 0; y < (at_y > 0 ? 1 : kBlockCells); ++y, word >>= kBlockCells, ids += kClosureSide) {
      const RowOrder order = kRowOrders[word & 0xFF];
      if (at_z > 0) {
        ids[0] = next;
      } else {
        for (std::size_t z = 0; z < kBlockCells; ++z) ids[z] = next + order.before[z];
      }
      next += order.all;
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
