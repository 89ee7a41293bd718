#include "extract/blocks/block_topology.h"

#include <algorithm>

#include "extract/blocks/bit_count.h"

namespace scanknit {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};
constexpr std::uint64_t kFirstOfRows = 0x0101010101010101u;  // z = 0 in each of the eight rows y

/// The bits of the 64 voxels one further along y, or along z, than those of `word`; `next` has the row, or layer, to
/// come.
constexpr std::uint64_t one_up_y(std::uint64_t word, std::uint64_t next) {
  return (word >> 8) | (next << 56);
}
constexpr std::uint64_t one_up_z(std::uint64_t word, std::uint64_t next) {
  return ((word >> 1) & ~(kFirstOfRows << 7)) | ((next & kFirstOfRows) << 7);
}
constexpr std::uint64_t one_down_y(std::uint64_t word, std::uint64_t previous) {
  return (word << 8) | (previous >> 56);
}
constexpr std::uint64_t one_down_z(std::uint64_t word, std::uint64_t previous) {
  return ((word << 1) & ~kFirstOfRows) | ((previous >> 7) & kFirstOfRows);
}

/// One kind of bits of the 27 blocks; blocks that are not there count as `absent`.
class BitField {
 public:
  BitField(const ClassifiedBlocks& signs, const Neighbours& neighbours, VoxelBits BlockSigns::*kind,
           const VoxelBits& absent) {
    std::transform(neighbours.all().begin(), neighbours.all().end(), blocks_.begin(),
                   [&](std::size_t block) { return block == kNoBlock ? &absent : &(signs[block].*kind); });
  }

  /// The bits of the voxels (x, y, z), (x, y + 1, z), (x, y, z + 1), (x, y + 1, z + 1); x from -1 to 8.
  [[nodiscard]] std::array<std::uint64_t, 4> upper(int x) const {
    const std::uint64_t here = word(x, 0, 0);
    const std::uint64_t here_up = one_up_y(here, word(x, 1, 0));
    const std::uint64_t next = word(x, 0, 1);
    return {here, here_up, one_up_z(here, next), one_up_z(here_up, one_up_y(next, word(x, 1, 1)))};
  }

  /// For each of the four cells at (x, y + dy, z + dz), dy and dz -1 or 0, [(dy + 1) + 2 (dz + 1)]: whether one of its
  /// four voxels in the plane x has the bit.
  [[nodiscard]] std::array<std::uint64_t, 4> any_in_cells(int x) const {
    const std::uint64_t centre = any_in_columns(x, 0, false);
    const std::uint64_t centre_down = any_in_columns(x, 0, true);
    return {centre_down | one_down_z(centre_down, any_in_columns(x, -1, true)),
            centre | one_down_z(centre, any_in_columns(x, -1, false)),
            centre_down | one_up_z(centre_down, any_in_columns(x, 1, true)),
            centre | one_up_z(centre, any_in_columns(x, 1, false))};
  }

 private:
  [[nodiscard]] std::uint64_t word(int x, int block_y, int block_z) const {
    const int block = 9 * ((x >> 3) + 1) + 3 * (block_y + 1) + block_z + 1;
    return (*blocks_[static_cast<std::size_t>(block)])[static_cast<std::size_t>(x & 7)];
  }

  /// Whether one of the voxels at y and y + 1, or at y - 1 and y, has the bit.
  [[nodiscard]] std::uint64_t any_in_columns(int x, int block_z, bool down) const {
    const std::uint64_t here = word(x, 0, block_z);
    return here | (down ? one_down_y(here, word(x, -1, block_z)) : one_up_y(here, word(x, 1, block_z)));
  }

  std::array<const VoxelBits*, 27> blocks_{};
};

constexpr VoxelBits kNothing{};
constexpr VoxelBits kEverything{kAll, kAll, kAll, kAll, kAll, kAll, kAll, kAll};

}  // namespace

BlockTopology::BlockTopology(const ClassifiedBlocks& signs, const Neighbours& neighbours) {
  const BitField high(signs, neighbours, &BlockSigns::high, kNothing);
  for (int x = 0; x <= kBlockCells; ++x) high_[static_cast<std::size_t>(x)] = high.upper(x);

  const auto is_whole = [&](std::size_t block) { return block != kNoBlock && signs.is_whole(block); };
  CellsAround valid;
  for (auto& cells : valid) cells.fill(kAll);
  if (!std::all_of(neighbours.all().begin(), neighbours.all().end(), is_whole)) {
    const BitField missing(signs, neighbours, &BlockSigns::missing, kEverything);
    for (int x = 0; x <= kBlockCells; ++x) missing_[static_cast<std::size_t>(x)] = missing.upper(x);
    for (int x = -1; x <= kBlockCells; ++x) {
      const auto is_missing = missing.any_in_cells(x);
      for (std::size_t i = 0; i < 4; ++i) {  // the plane x belongs to the cells that begin there and to those before
        if (x > 0) valid[static_cast<std::size_t>(x - 1)][2 * i + 1] &= ~is_missing[i];
        if (x >= 0 && x < kBlockCells) {
          valid[static_cast<std::size_t>(x)][2 * i] &= ~is_missing[i];
          valid[static_cast<std::size_t>(x)][2 * i + 1] &= ~is_missing[i];
        }
        if (x + 1 < kBlockCells) valid[static_cast<std::size_t>(x + 1)][2 * i] &= ~is_missing[i];
      }
    }
  }
  find_active_cells(valid);
  find_vertices(valid);
}

void BlockTopology::find_active_cells(const CellsAround& valid) {
  for (std::size_t x = 0; x < kBlockCells; ++x) {
    std::uint64_t any_high = 0;
    std::uint64_t any_low = 0;
    for (const std::size_t side : {x, x + 1}) {
      for (std::size_t i = 0; i < 4; ++i) {
        any_high |= high_[side][i];
        any_low |= ~(high_[side][i] | missing_[side][i]);
      }
    }
    const std::uint64_t is_valid = valid[x][7];
    active_cells_[x] = is_valid & any_high & any_low;
    cells_without_surface_ += std::size_t{count_bits(is_valid & ~active_cells_[x])};
    skipped_cells_ += std::size_t{count_bits(any_high & any_low & ~is_valid)};
  }
}

void BlockTopology::find_vertices(const CellsAround& valid) {
  for (std::size_t x = 0; x < kBlockCells; ++x) {
    const std::uint64_t here = high_[x][0];
    const std::array crossed{here ^ high_[x + 1][0], here ^ high_[x][1], here ^ high_[x][2]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // The cells round an edge: at its own voxel (7), one back along the first and the second other axis, and both.
      const std::size_t first = axis == 0 ? 2 : 1;
      const std::size_t second = axis == 2 ? 2 : 4;
      const std::uint64_t a = valid[x][7];
      const std::uint64_t b = valid[x][7 - first];
      const std::uint64_t c = valid[x][7 - second];
      const std::uint64_t d = valid[x][7 - first - second];
      vertices_[axis][x] = crossed[axis] & (a | b | c | d);
      pinched_[axis][x] = crossed[axis] & ((a & d & ~b & ~c) | (b & c & ~a & ~d));
    }
  }
}

}  // namespace scanknit
