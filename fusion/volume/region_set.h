// RegionSet: a part of space, in regions of 8^3 blocks.
#pragma once

#include <openvdb/openvdb.h>

#include <bitset>
#include <cstddef>
#include <unordered_set>

#include "fusion/volume/block_index.h"

namespace scanknit {

inline constexpr int kRegionVoxels = BlockIndex::kRegionVoxels;

/// The lowest voxel of the region that has the block, or voxel, at `origin`.
[[nodiscard]] inline openvdb::Coord region_of(const openvdb::Coord& origin) {
  return origin & ~(kRegionVoxels - 1);
}

/// The number of a block in its region: 64 x + 8 y + z, in blocks.
[[nodiscard]] inline std::size_t number_in_region(const openvdb::Coord& block) {
  const openvdb::Coord at = (block - region_of(block)) >> 3;
  return static_cast<std::size_t>(64 * at.x() + 8 * at.y() + at.z());
}

/// The lowest voxel of the block with this number.
[[nodiscard]] inline openvdb::Coord block_of(const openvdb::Coord& region, std::size_t number) {
  const int n = static_cast<int>(number);
  return region + openvdb::Coord(n / 64 * 8, n / 8 % 8 * 8, n % 8 * 8);
}

/// Blocks of one region, by their numbers.
using BlocksOfRegion = std::bitset<512>;

/// Regions by their lowest voxels: multiples of kRegionVoxels, as in BlockIndex.
using RegionSet = std::unordered_set<openvdb::Coord>;

}  // namespace scanknit
