// VoxelReader: the field between samples, for rays that pass from block to block.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "fusion/block_index.h"

namespace scanknit {

/// A cell of eight samples: corner x + 2 y + 4 z.
template <typename T>
using Cell = std::array<T, 8>;

/// Coordinates in voxels. Keeps the blocks it came by at hand; one for each thread, not beyond a change of the volume.
class VoxelReader {
 public:
  explicit VoxelReader(const BlockIndex& index) : index_(index) {}

  struct At {
    int x, y, z;
  };
  [[nodiscard]] static At floor_of(const Eigen::Vector3f& p) {
    return {floor_of(p.x()), floor_of(p.y()), floor_of(p.z())};
  }

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

  /// Sample `at` of a block as OpenVDB counts them.
  [[nodiscard]] static unsigned offset_of(const At& at) {
    return static_cast<unsigned>((at.x & 7) << 6 | (at.y & 7) << 3 | (at.z & 7));
  }
  [[nodiscard]] static bool is_observed(const VolumeBlock& block, unsigned offset) {
    return block.tsdf->getValueMask().isOn(offset);
  }

  /// Distances at the corners of the cell whose lowest sample is `low`; false where one of them is unknown.
  [[nodiscard]] bool distances(const At& low, Cell<float>& values) {
    const bool is_within = (low.x & 7) != 7 && (low.y & 7) != 7 && (low.z & 7) != 7;
    if (!is_within) return distances_across(low, values);
    const VolumeBlock* block = block_at(low);
    if (block == nullptr) return false;
    const unsigned offset = offset_of(low);
    const auto& mask = block->tsdf->getValueMask();
    constexpr std::uint64_t kFour = 0x303;  // z and z + 1 of y and y + 1
    const std::uint64_t both =
        mask.getWord<std::uint64_t>(offset >> 6) & mask.getWord<std::uint64_t>((offset >> 6) + 1);
    if ((both >> (offset & 63) & kFour) != kFour) return false;
    const float* v = block->tsdf->buffer().data() + offset;
    values = {v[0], v[64], v[8], v[72], v[1], v[65], v[9], v[73]};
    return true;
  }

  /// Colours at the corners of a cell; 0 where there is none.
  void colours(const At& low, Cell<ColourCode>& codes) {
    for (int corner = 0; corner < 8; ++corner) {
      const At at = corner_of(low, corner);
      const VolumeBlock* block = block_at(at);
      codes[static_cast<std::size_t>(corner)] = block == nullptr ? 0 : block->colour->buffer().data()[offset_of(at)];
    }
  }

 private:
  struct Slot {
    openvdb::Coord origin;
    const VolumeBlock* block = nullptr;
    bool is_known = false;
  };

  [[nodiscard]] static int floor_of(float v) {
    const int truncated = static_cast<int>(v);
    return truncated - (v < static_cast<float>(truncated) ? 1 : 0);
  }
  [[nodiscard]] static At corner_of(const At& low, int corner) {
    return {low.x + (corner & 1), low.y + ((corner >> 1) & 1), low.z + (corner >> 2)};
  }
  [[nodiscard]] static std::size_t slot_of(const At& at) {
    return static_cast<std::size_t>((at.x >> 3 & 3) << 4 | (at.y >> 3 & 3) << 2 | (at.z >> 3 & 3));
  }

  [[nodiscard]] bool distances_across(const At& low, Cell<float>& values) {
    for (int corner = 0; corner < 8; ++corner) {
      const At at = corner_of(low, corner);
      const VolumeBlock* block = block_at(at);
      const unsigned offset = offset_of(at);
      if (block == nullptr || !is_observed(*block, offset)) return false;
      values[static_cast<std::size_t>(corner)] = block->tsdf->buffer().data()[offset];
    }
    return true;
  }

  const BlockIndex& index_;
  std::array<Slot, 64> slots_;
};

}  // namespace scanknit
