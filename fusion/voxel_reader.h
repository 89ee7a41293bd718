// VoxelReader: single samples and cells of them, for rays that pass from block to block.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "fusion/block_index.h"

namespace scanknit {

/// Keeps the blocks it came by at hand; one for each thread, not beyond a change of the volume. A cell is the eight
/// samples from `low` to the next along each axis, corner x + 2 y + 4 z; corner n is written to `values[n stride]`.
class VoxelReader {
 public:
  explicit VoxelReader(const BlockIndex& index) : index_(index) {}

  /// A sample, in voxels.
  struct At {
    int x, y, z;
    bool operator==(const At&) const = default;
  };
  [[nodiscard]] static int floor_of(float v) {
    const int truncated = static_cast<int>(v);
    return truncated - (v < static_cast<float>(truncated) ? 1 : 0);
  }

  /// Has `block` at hand, for what lies in it.
  void keep(const VolumeBlock& block) {
    slots_[slot_of({block.origin.x(), block.origin.y(), block.origin.z()})] = Block(block);
  }

  /// The distance at a sample; nothing where it is unknown.
  [[nodiscard]] std::optional<float> distance(const At& at) {
    const Block& block = block_at(at);
    const unsigned offset = offset_of(at);
    if (!block.is_observed(offset)) return std::nullopt;
    return block.distances[offset];
  }

  /// Distances at the corners of a cell; false where one of them is unknown.
  [[nodiscard]] bool distances(const At& low, float* values, std::size_t stride) {
    if (!is_within_block(low)) return distances_across(low, values, stride);
    const Block& block = block_at(low);
    if (block.distances == nullptr) return false;
    const unsigned offset = offset_of(low);
    constexpr std::uint64_t kFour = 0x303;  // z and z + 1 of y and y + 1
    const std::uint64_t both =
        block.observed->getWord<std::uint64_t>(offset >> 6) & block.observed->getWord<std::uint64_t>((offset >> 6) + 1);
    if ((both >> (offset & 63) & kFour) != kFour) return false;
    copy_cell(block.distances + offset, values, stride);
    return true;
  }

  /// Colours at the corners of a cell; 0 where there is none.
  void colours(const At& low, ColourCode* codes, std::size_t stride) {
    if (is_within_block(low)) {
      const Block& block = block_at(low);
      if (block.colours != nullptr) copy_cell(block.colours + offset_of(low), codes, stride);
      return;
    }
    const auto blocks = blocks_at(low);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const ColourCode* colours = blocks[corner]->colours;
      codes[corner * stride] = colours == nullptr ? 0 : colours[offset_of(corner_of(low, corner))];
    }
  }

  /// Asks the memory for what colours() will read.
  void prefetch_colours(const At& low) {
    if (is_within_block(low)) {
      if (const ColourCode* colours = block_at(low).colours) prefetch_cell(colours + offset_of(low), low);
      return;
    }
    const auto blocks = blocks_at(low);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const ColourCode* colours = blocks[corner]->colours;
      if (colours != nullptr) __builtin_prefetch(colours + offset_of(corner_of(low, corner)));
    }
  }

 private:
  /// A block's samples; null where the volume has no such block.
  struct Block {
    openvdb::Coord origin{1, 1, 1};  // of no block
    const float* distances = nullptr;
    const TsdfLeaf::NodeMaskType* observed = nullptr;
    const ColourCode* colours = nullptr;

    Block() = default;
    explicit Block(const openvdb::Coord& empty) : origin(empty) {}
    explicit Block(const VolumeBlock& block)
        : origin(block.origin),
          distances(block.tsdf->buffer().data()),
          observed(&block.tsdf->getValueMask()),
          colours(block.colour->buffer().data()) {}
    [[nodiscard]] bool is_observed(unsigned offset) const { return distances != nullptr && observed->isOn(offset); }
  };

  /// The block that holds a sample.
  [[nodiscard]] const Block& block_at(const At& at) {
    Block& block = slots_[slot_of(at)];
    const openvdb::Coord origin(at.x & ~7, at.y & ~7, at.z & ~7);
    if (block.origin != origin) {
      const BlockIndex::Number number = index_.find(origin);
      block = number == BlockIndex::kNone ? Block(origin) : Block(index_.blocks()[number]);
    }
    return block;
  }
  /// The blocks that hold the corners of a cell: neighbours, which do not take each other's slots.
  [[nodiscard]] std::array<const Block*, 8> blocks_at(const At& low) {
    const unsigned across = ((low.x & 7) == 7 ? 1u : 0u) | ((low.y & 7) == 7 ? 2u : 0u) | ((low.z & 7) == 7 ? 4u : 0u);
    std::array<const Block*, 8> blocks;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const unsigned same = corner & across;  // the first corner in the same block
      blocks[corner] = same == corner ? &block_at(corner_of(low, corner)) : blocks[same];
    }
    return blocks;
  }
  [[nodiscard]] static std::size_t slot_of(const At& at) {
    return static_cast<std::size_t>((at.x >> 3 & 7) << 6 | (at.y >> 3 & 7) << 3 | (at.z >> 3 & 7));
  }

  /// Sample `at` of a block as OpenVDB counts them.
  [[nodiscard]] static unsigned offset_of(const At& at) {
    return static_cast<unsigned>((at.x & 7) << 6 | (at.y & 7) << 3 | (at.z & 7));
  }
  [[nodiscard]] static bool is_within_block(const At& low) {
    return (low.x & 7) != 7 && (low.y & 7) != 7 && (low.z & 7) != 7;
  }
  [[nodiscard]] static At corner_of(const At& low, unsigned corner) {
    return {low.x + static_cast<int>(corner & 1), low.y + static_cast<int>(corner >> 1 & 1),
            low.z + static_cast<int>(corner >> 2)};
  }
  template <typename T>
  static void copy_cell(const T* first, T* values, std::size_t stride) {
    constexpr std::array<unsigned, 8> kOffsets{0, 64, 8, 72, 1, 65, 9, 73};
    for (std::size_t corner = 0; corner < 8; ++corner) values[corner * stride] = first[kOffsets[corner]];
  }

  /// A cache line holds two rows along z.
  static void prefetch_cell(const ColourCode* first, const At& low) {
    __builtin_prefetch(first);
    __builtin_prefetch(first + 64);
    if ((low.y & 1) == 0) return;
    __builtin_prefetch(first + 8);
    __builtin_prefetch(first + 72);
  }

  [[nodiscard]] bool distances_across(const At& low, float* values, std::size_t stride) {
    const auto blocks = blocks_at(low);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const unsigned offset = offset_of(corner_of(low, corner));
      if (!blocks[corner]->is_observed(offset)) return false;
      values[corner * stride] = blocks[corner]->distances[offset];
    }
    return true;
  }

  const BlockIndex& index_;
  std::array<Block, 512> slots_;
};

}  // namespace scanknit
