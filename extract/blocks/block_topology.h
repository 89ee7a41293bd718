// BlockTopology: finds the cells of a block that meet the isosurface, and the grid edges with vertices.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "extract/blocks/block.h"
#include "extract/blocks/classified_blocks.h"
#include "extract/blocks/neighbours.h"
#include "extract/cell/cell.h"

namespace scanknit {

/// One bit for each grid edge that a block owns: an edge whose low end is one of its voxels; [axis].
using EdgeBits = std::array<VoxelBits, 3>;

/// Swaps rows and columns of an 8 x 8 matrix of bits, one row a byte (Warren, Hacker's Delight, section 7-3).
constexpr std::uint64_t transposed(std::uint64_t m) {
  std::uint64_t t = (m ^ (m >> 7)) & 0x00AA00AA00AA00AAu;
  m ^= t ^ (t << 7);
  t = (m ^ (m >> 14)) & 0x0000CCCC0000CCCCu;
  m ^= t ^ (t << 14);
  t = (m ^ (m >> 28)) & 0x00000000F0F0F0F0u;
  return m ^ t ^ (t << 28);
}

/// A cell is valid if all eight corners are observed, and active if it also has both High and Low corners.
class BlockTopology {
 public:
  BlockTopology(const ClassifiedBlocks& signs, const Neighbours& neighbours);

  [[nodiscard]] const VoxelBits& active_cells() const { return active_cells_; }

  /// Grid edges from High to Low, or back, that at least one valid cell uses.
  [[nodiscard]] const EdgeBits& vertices() const { return vertices_; }

  /// The edges of `vertices()` that exactly two valid cells use, opposite each other across the edge: the surface
  /// touches itself there, and each of the two cells gets its own vertex (is_second_fan).
  [[nodiscard]] const EdgeBits& pinched() const { return pinched_; }

  /// Calls visit(x, y, z, highs) for each active cell in order of x, y, z; `highs` is its CornerMask.
  template <typename Visit>
  void for_each_active_cell(const Visit& visit) const;

  [[nodiscard]] std::size_t cells_without_surface() const { return cells_without_surface_; }
  [[nodiscard]] std::size_t skipped_cells() const { return skipped_cells_; }

 private:
  /// For each x from 0 to 8 the signs of the voxels at (x, y + dy, z + dz), [x][dy + 2 dz].
  using CornerPlanes = std::array<std::array<std::uint64_t, 4>, kBlockCells + 1>;
  /// For each x the cells at (x + dx, y + dy, z + dz), dx dy dz each -1 or 0; [x][(dx + 1) + 2 (dy + 1) + 4 (dz + 1)].
  using CellsAround = std::array<std::array<std::uint64_t, 8>, kBlockCells>;

  /// The eight cells (x, y, 0) to (x, y, 7): byte z is the cell's CornerMask.
  [[nodiscard]] std::uint64_t highs_of_row(int x, int y) const {
    std::uint64_t corners = 0;
    for (unsigned corner = 0; corner < kCorners; ++corner) {
      const std::uint64_t plane = high_[static_cast<std::size_t>(x) + (corner & 1)][corner >> 1];
      corners |= ((plane >> (8 * y)) & 0xFFu) << (8 * corner);
    }
    return transposed(corners);
  }

  void find_active_cells(const CellsAround& valid);
  void find_vertices(const CellsAround& valid);

  CornerPlanes high_;
  CornerPlanes missing_{};
  VoxelBits active_cells_;
  EdgeBits vertices_;
  EdgeBits pinched_;
  std::size_t cells_without_surface_ = 0;
  std::size_t skipped_cells_ = 0;
};

template <typename Visit>
void BlockTopology::for_each_active_cell(const Visit& visit) const {
  for (int x = 0; x < kBlockCells; ++x) {
    std::uint64_t cells = active_cells_[static_cast<std::size_t>(x)];
    if (cells == 0) continue;
    std::array<std::uint64_t, kBlockCells> rows;
    for (int y = 0; y < kBlockCells; ++y) rows[static_cast<std::size_t>(y)] = highs_of_row(x, y);
    for (; cells != 0; cells &= cells - 1) {  // one loop, because the ends of a loop for each row are hard to predict
      const int cell = std::countr_zero(cells);
      const int y = cell / kBlockCells;
      const int z = cell % kBlockCells;
      visit(x, y, z, static_cast<CornerMask>(rows[static_cast<std::size_t>(y)] >> (8 * z)));
    }
  }
}

/// True for the second of the two opposite cells that use a pinched edge. `edge` is the edge's number in the cell: the
/// second cell is the one in which the last of the edge's two fixed coordinates is 1.
[[nodiscard]] constexpr bool is_second_fan(int edge) {
  return (edge % 4) >> 1 == 1;
}

}  // namespace scanknit
