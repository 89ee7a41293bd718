// RegionSet: a part of space, in regions of 8^3 blocks.
#pragma once

#include <openvdb/openvdb.h>

#include <unordered_set>

#include "fusion/volume/block_index.h"

namespace scanknit {

inline constexpr int kRegionVoxels = BlockIndex::kRegionVoxels;

/// The lowest voxel of the region that has the block, or voxel, at `origin`.
[[nodiscard]] inline openvdb::Coord region_of(const openvdb::Coord& origin) {
  return origin & ~(kRegionVoxels - 1);
}

/// Regions by their lowest voxels: multiples of kRegionVoxels, as in BlockIndex.
using RegionSet = std::unordered_set<openvdb::Coord>;

}  // namespace scanknit
