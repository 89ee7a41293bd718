// BlockCopies: copies of some blocks' samples in one array, for vector instructions.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fusion/volume/block_index.h"

namespace scanknit {

/// A table from blocks to copies of their samples. A newer block may replace an older one in its slot, so that the
/// older copy is no longer found; copies keep their place until clear().
template <typename T>
class BlockCopies {
 public:
  static constexpr int kSlotBits = 4;           ///< for each axis
  static constexpr int kKeyBits = 10;           ///< for each axis
  static constexpr std::int32_t kNoBlock = -1;  ///< no key
  static constexpr std::int32_t kEmpty = 0;     ///< start of the samples for blocks that are not in the volume

  /// The samples of a block that is not in the volume.
  explicit BlockCopies(const T& none)
      : keys_(std::size_t{1} << (3 * kSlotBits), kNoBlock), starts_(keys_.size(), kEmpty) {
    copies_.emplace_back();
    copies_.front().samples.fill(none);
  }

  /// Removes all blocks.
  void clear() {
    for (const std::int32_t slot : used_slots_) keys_[static_cast<std::size_t>(slot)] = kNoBlock;
    used_slots_.clear();
    copies_.resize(1);
  }

  /// keys()[slot_of(block)] is key_of(block) if the table has that block; its samples are then copied to samples() +
  /// starts()[slot_of(block)]. Blocks 2^14 blocks apart along an axis have the same key; see kFarthestBlocks.
  [[nodiscard]] const std::int32_t* keys() const { return keys_.data(); }
  [[nodiscard]] const std::int32_t* starts() const { return starts_.data(); }
  [[nodiscard]] const T* samples() const { return copies_.front().samples.data(); }

  [[nodiscard]] static std::int32_t slot_of(const openvdb::Coord& sample) { return mix(sample >> 3, kSlotBits); }
  [[nodiscard]] static std::int32_t key_of(const openvdb::Coord& sample) {
    return mix(sample >> (3 + kSlotBits), kKeyBits);
  }
  [[nodiscard]] bool contains(const openvdb::Coord& sample) const {
    return keys_[static_cast<std::size_t>(slot_of(sample))] == key_of(sample);
  }
  /// The start of the samples of a block that the table has.
  [[nodiscard]] std::int32_t start_of(const openvdb::Coord& sample) const {
    return starts_[static_cast<std::size_t>(slot_of(sample))];
  }

  /// Adds the block of a sample; that block is not in the volume.
  std::int32_t add_empty(const openvdb::Coord& sample) { return enter(sample, kEmpty); }
  /// Adds the block of a sample and returns the start of its samples, which the caller must fill in.
  std::int32_t add(const openvdb::Coord& sample) {
    copies_.emplace_back();
    return enter(sample, static_cast<std::int32_t>((copies_.size() - 1) * TsdfLeaf::SIZE));
  }
  [[nodiscard]] T* samples_at(std::int32_t start) { return copies_.front().samples.data() + start; }

 private:
  struct Copy {
    Copy() {}  // uninitialised: the samples are filled in later
    alignas(64) std::array<T, TsdfLeaf::SIZE> samples;
  };
  static_assert(sizeof(Copy) == TsdfLeaf::SIZE * sizeof(T), "samples lie side by side");

  /// The lowest bits along each axis, those of x lowest.
  [[nodiscard]] static std::int32_t mix(const openvdb::Coord& at, int bits) {
    const int last = (1 << bits) - 1;
    return (at.x() & last) | (at.y() & last) << bits | (at.z() & last) << 2 * bits;
  }

  std::int32_t enter(const openvdb::Coord& sample, std::int32_t start) {
    const std::int32_t slot = slot_of(sample);
    keys_[static_cast<std::size_t>(slot)] = key_of(sample);
    starts_[static_cast<std::size_t>(slot)] = start;
    used_slots_.push_back(slot);
    return start;
  }

  std::vector<std::int32_t> keys_, starts_, used_slots_;
  std::vector<Copy> copies_;
};

/// The parts of the volume that a tile's rays read.
class TileSamples {
 public:
  explicit TileSamples(const BlockIndex& index);

  void clear();

  /// Copies of distances, NaN where nothing is known, and of colours, 0 where there is none.
  [[nodiscard]] const BlockCopies<float>& distances() const { return distances_; }
  [[nodiscard]] const BlockCopies<std::uint32_t>& colours() const { return colours_; }

  /// Copies a block's distances again; returns where they begin.
  std::int32_t add_distances(BlockIndex::Number number);
  /// The start of the distances, or colours, of the block of a sample; copies them if necessary.
  std::int32_t distances_round(const openvdb::Coord& sample);
  std::int32_t colours_round(const openvdb::Coord& sample);

 private:
  [[nodiscard]] BlockIndex::Number block_round(const openvdb::Coord& sample) const;

  const BlockIndex& index_;
  BlockCopies<float> distances_;
  BlockCopies<std::uint32_t> colours_;
  std::vector<BlockIndex::Number> copied_;  ///< the blocks of the copied distances, in order
};

}  // namespace scanknit
