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
  };
  [[nodiscard]] static int floor_of(float v) {
    const int truncated = static_cast<int>(v);
    return truncated - (v < static_cast<float>(truncated) ? 1 : 0);
  }

  /// The distance at a sample; nothing where it is unknown.
  [[nodiscard]] std::optional<float> distance(const At& at) {
    const VolumeBlock* block = block_at(at);
    const unsigned offset = offset_of(at);
    if (block == nullptr || !block->tsdf->getValueMask().isOn(offset)) return std::nullopt;
    return block->tsdf->buffer().data()[offset];
  }

  /// Distances at the corners of a cell; false where one of them is unknown.
  [[nodiscard]] bool distances(const At& low, float* values, std::size_t stride) {
    if (!is_within_block(low)) return distances_across(low, values, stride);
    const VolumeBlock* block = block_at(low);
    if (block == nullptr) return false;
    const unsigned offset = offset_of(low);
    const auto& mask = block->tsdf->getValueMask();
    constexpr std::uint64_t kFour = 0x303;  // z and z + 1 of y and y + 1
    const std::uint64_t both =
        mask.getWord<std::uint64_t>(offset >> 6) & mask.getWord<std::uint64_t>((offset >> 6) + 1);
    if ((both >> (offset & 63) & kFour) != kFour) return false;
    copy_cell(block->tsdf->buffer().data() + offset, values, stride);
    return true;
  }

  /// Colours at the corners of a cell; 0 where there is none.
  void colours(const At& low, ColourCode* codes, std::size_t stride) {
    if (is_within_block(low)) {
      const VolumeBlock* block = block_at(low);
      if (block != nullptr) copy_cell(block->colour->buffer().data() + offset_of(low), codes, stride);
      return;
    }
    const auto blocks = blocks_at(low);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const VolumeBlock* block = blocks[corner];
      codes[corner * stride] = block == nullptr ? 0 : block->colour->buffer().data()[offset_of(corner_of(low, corner))];
    }
  }

  /// Asks the memory for most of what distances() and colours() will read.
  void prefetch_distances(const At& low) {
    const VolumeBlock* block = block_at(low);
    if (block == nullptr) return;
    __builtin_prefetch(&block->tsdf->getValueMask());
    prefetch_cell(block->tsdf->buffer().data(), low);
  }
  void prefetch_colours(const At& low) {
    if (const VolumeBlock* block = block_at(low)) prefetch_cell(block->colour->buffer().data(), low);
  }

 private:
  struct Slot {
    openvdb::Coord origin;
    const VolumeBlock* block = nullptr;
    bool is_known = false;
  };

  /// The block that holds a sample, or null.
  [[nodiscard]] const VolumeBlock* block_at(const At& at) {
    Slot& slot = slots_[slot_of(at)];
    const openvdb::Coord origin(at.x & ~7, at.y & ~7, at.z & ~7);
    if (!slot.is_known || slot.origin != origin) {
      const BlockIndex::Number number = index_.find(origin);
      slot = {origin, number == BlockIndex::kNone ? nullptr : &index_.blocks()[number], true};
    }
    return slot.block;
  }
  /// The blocks that hold the corners of a cell.
  [[nodiscard]] std::array<const VolumeBlock*, 8> blocks_at(const At& low) {
    const unsigned across = ((low.x & 7) == 7 ? 1u : 0u) | ((low.y & 7) == 7 ? 2u : 0u) | ((low.z & 7) == 7 ? 4u : 0u);
    std::array<const VolumeBlock*, 8> blocks;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const unsigned same = corner & across;  // the first corner in the same block
      blocks[corner] = same == corner ? block_at(corner_of(low, corner)) : blocks[same];
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
  template <typename T>
  static void prefetch_cell(const T* values, const At& low) {
    const T* first = values + offset_of(low);
    const bool is_in_two_lines = (low.y & 1) != 0 && (low.y & 7) != 7;
    __builtin_prefetch(first);
    if (is_in_two_lines) __builtin_prefetch(first + 8);
    if ((low.x & 7) == 7) return;
    __builtin_prefetch(first + 64);
    if (is_in_two_lines) __builtin_prefetch(first + 72);
  }

  [[nodiscard]] bool distances_across(const At& low, float* values, std::size_t stride) {
    const auto blocks = blocks_at(low);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const VolumeBlock* block = blocks[corner];
      const unsigned offset = offset_of(corner_of(low, corner));
      if (block == nullptr || !block->tsdf->getValueMask().isOn(offset)) return false;
      values[corner * stride] = block->tsdf->buffer().data()[offset];
    }
    return true;
  }

  const BlockIndex& index_;
  std::array<Slot, 512> slots_;
};

}  // namespace scanknit
