// BlockTopology: which cells of a block meet the isosurface, and which grid edges carry vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "extract/block.h"
#include "extract/cell.h"

namespace scanknit {

/// One bit for each of a block's 512 voxels (or cells): word x, bit 8 y + z.
using VoxelBits = std::array<std::uint64_t, kBlockCells>;
/// One bit for each grid edge that a block owns, that is whose low end is one of its voxels; [axis].
using EdgeBits = std::array<VoxelBits, 3>;

/// The smallest float not below `isovalue`: for a float v, v >= isovalue iff v >= this.
[[nodiscard]] float float_isovalue(double isovalue);

/// A cell is valid iff its eight corners are observed, active iff it is valid and has a High and a Low corner.
class BlockTopology {
 public:
  BlockTopology(const ValueBlock& values, float isovalue);

  [[nodiscard]] const VoxelBits& active_cells() const { return active_cells_; }

  /// Grid edges from High to Low, or back, that at least one valid cell uses.
  [[nodiscard]] const EdgeBits& vertices() const { return vertices_; }

  /// Those of `vertices()` that exactly two valid cells use, lying opposite each other across the edge: the surface
  /// touches itself there, and each of the two cells gets a vertex of its own (is_second_fan).
  [[nodiscard]] const EdgeBits& pinched() const { return pinched_; }

  [[nodiscard]] CornerMask highs(int x, int y, int z) const;

  [[nodiscard]] std::size_t cells_without_surface() const { return cells_without_surface_; }
  [[nodiscard]] std::size_t skipped_cells() const { return skipped_cells_; }

 private:
  // One bit for each sample z from -1 to 8 (bit z + 1) of a row.
  using RowBits = std::uint16_t;
  static constexpr int kRows = kBlockCells + 2;  // x and y from -1 to 8
  using Rows = std::array<std::array<RowBits, kRows>, kRows>;
  [[nodiscard]] static RowBits row(const Rows& rows, int x, int y) {
    return rows[static_cast<std::size_t>(x + 1)][static_cast<std::size_t>(y + 1)];
  }

  void classify_samples(const ValueBlock& values, float isovalue);
  void classify_cells();
  void find_vertices();
  void add_vertices(int axis, int x, int y, unsigned crossed, const std::array<unsigned, 4>& valid_around);

  Rows high_{};
  Rows observed_{};
  Rows valid_{};  // by cell
  VoxelBits active_cells_{};
  EdgeBits vertices_{};
  EdgeBits pinched_{};
  std::size_t cells_without_surface_ = 0;
  std::size_t skipped_cells_ = 0;
};

/// Of the four cells round a pinched edge two opposite ones are left; which of them a cell is follows from where the
/// edge lies in it: the second is the cell in which the edge has 1 for the last of its two fixed coordinates.
[[nodiscard]] constexpr bool is_second_fan(int edge) {
  return (edge % 4) >> 1 == 1;
}

}  // namespace scanknit
