// BlockIndex: from a block's origin to its leaves, without a walk through three trees.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/field_view.h"
#include "core/voxel_codes.h"
#include "fusion/volume/block_size.h"

namespace scanknit {

using TsdfGrid = openvdb::FloatGrid;
using TsdfLeaf = TsdfGrid::TreeType::LeafNodeType;
using WeightLeaf = WeightCodeGrid::TreeType::LeafNodeType;
using ColourLeaf = ColourCodeGrid::TreeType::LeafNodeType;
static_assert(TsdfLeaf::DIM == kBlockEdgeVoxels && TsdfLeaf::SIZE == kBlockVoxels);

/// A leaf of colours has memory for them from the first one on. Before, it reads as zeros; buffer().data() gives it
/// that memory, as accessors do that read it.
[[nodiscard]] inline bool has_own_colours(const ColourLeaf& leaf) {
  return !leaf.buffer().empty();
}
/// 512 codes; for reading, and without giving it memory.
[[nodiscard]] const ColourCode* colours_of(const ColourLeaf& leaf);

/// The leaves of one block of 8^3 voxels, owned by their trees; they stay where they are until a tree is pruned.
struct VolumeBlock {
  openvdb::Coord origin;
  TsdfLeaf* tsdf = nullptr;
  WeightLeaf* weight = nullptr;
  ColourLeaf* colour = nullptr;
  std::uint32_t last_frame = 0;  ///< that updated it
  bool is_free = false;          ///< every voxel is known to be free space
  bool has_matter = false;       ///< some voxel was behind a surface, once
  bool has_changed = false;      ///< since somebody last asked
};

/// Blocks in the order in which they were added. A table has their regions, each of which has its blocks by place: who
/// asks for one block after the other finds most in the cache.
class BlockIndex {
 public:
  using Number = std::uint32_t;
  static constexpr Number kNone = ~Number{0};

  /// Blocks within a cube of 8^3 blocks, for asking about many at once.
  static constexpr int kRegionBlocks = 8;   ///< along an edge
  static constexpr int kRegionVoxels = 64;  ///< likewise
  struct Region {
    explicit Region(const openvdb::Coord& lowest);

    openvdb::Coord origin;
    std::vector<Number> blocks;
    std::array<Number, kRegionBlocks * kRegionBlocks * kRegionBlocks> numbers;  ///< by place; kNone: not in the volume
  };

  /// The number of the block at `origin`, or kNone.
  [[nodiscard]] Number find(const openvdb::Coord& origin) const;
  /// `block.origin` is not in it yet.
  void add(const VolumeBlock& block);

  [[nodiscard]] std::span<VolumeBlock> blocks() { return blocks_; }
  [[nodiscard]] std::span<const VolumeBlock> blocks() const { return blocks_; }
  [[nodiscard]] std::span<const std::unique_ptr<Region>> regions() const { return regions_; }

 private:
  [[nodiscard]] Number find_region(const openvdb::Coord& origin) const;
  void enter_last_region();
  void enter_region(Number number);

  std::vector<VolumeBlock> blocks_;
  std::vector<std::unique_ptr<Region>> regions_;
  std::vector<Number> slots_;  ///< of regions: open addressing with linear probing, at most half full
};

}  // namespace scanknit
