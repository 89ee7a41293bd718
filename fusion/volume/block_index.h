// BlockIndex: finds a block's leaves by its origin, without a search in three trees.
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

/// True when the leaf has memory for colours. It gets the memory with its first colour and reads as zeros before.
/// buffer().data(), and accessors that read the leaf, allocate that memory.
[[nodiscard]] inline bool has_own_colours(const ColourLeaf& leaf) {
  return !leaf.buffer().empty();
}
/// The leaf's 512 codes, for reading; does not allocate memory.
[[nodiscard]] const ColourCode* colours_of(const ColourLeaf& leaf);

/// The leaves of one block of 8^3 voxels, owned by their trees; they keep their addresses until a tree is pruned.
struct VolumeBlock {
  openvdb::Coord origin;
  TsdfLeaf* tsdf = nullptr;
  WeightLeaf* weight = nullptr;
  ColourLeaf* colour = nullptr;
  std::uint32_t last_frame = 0;  ///< the frame that updated it last
  bool is_free = false;          ///< every voxel is known to be free space
  bool has_matter = false;       ///< some voxel has been behind a surface
  bool has_changed = false;      ///< since the last take_changed_blocks()
};

/// Blocks in the order in which they were added. A hash table has their regions, and each region has its blocks by
/// position, so that successive look-ups of near blocks mostly hit the cache.
class BlockIndex {
 public:
  using Number = std::uint32_t;
  static constexpr Number kNone = ~Number{0};

  /// The blocks in a cube of 8^3 blocks, to look up many at once.
  static constexpr int kRegionBlocks = 8;   ///< blocks along an edge
  static constexpr int kRegionVoxels = 64;  ///< voxels along an edge
  struct Region {
    explicit Region(const openvdb::Coord& lowest);

    openvdb::Coord origin;
    std::vector<Number> blocks;
    std::array<Number, kRegionBlocks * kRegionBlocks * kRegionBlocks> numbers;  ///< kNone: not in the volume
  };

  /// The number of the block at `origin`, or kNone.
  [[nodiscard]] Number find(const openvdb::Coord& origin) const;
  /// Adds a block whose origin the index does not have yet.
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
  std::vector<Number> slots_;  ///< hash table of regions: open addressing with linear probing, at most half full
};

}  // namespace scanknit
