// NewBlock: a block before it is added to the volume.
#pragma once

#include <openvdb/openvdb.h>

#include <memory>

#include "fusion/volume/block_index.h"

namespace scanknit {

/// Owns the leaves of its block, until TsdfVolume::add_block takes them.
struct NewBlock {
  /// Without leaves.
  NewBlock() = default;
  /// Every voxel is unknown, its distance `background_m`; without memory for colours.
  NewBlock(const openvdb::Coord& origin, float background_m)
      : tsdf(std::make_unique<TsdfLeaf>(origin, background_m)),
        weight(std::make_unique<WeightLeaf>(origin, WeightCode{0})),
        colour(std::make_unique<ColourLeaf>(openvdb::PartialCreate(), origin, ColourCode{0})),
        block{.origin = origin, .tsdf = tsdf.get(), .weight = weight.get(), .colour = colour.get()} {}

  [[nodiscard]] bool has_leaves() const { return tsdf != nullptr; }

  /// Moves it to another origin. It must have leaves, whose voxels are all unknown.
  void move_to(const openvdb::Coord& origin) {
    tsdf->setOrigin(origin);
    weight->setOrigin(origin);
    colour->setOrigin(origin);
    block = {.origin = origin, .tsdf = tsdf.get(), .weight = weight.get(), .colour = colour.get()};
  }

  std::unique_ptr<TsdfLeaf> tsdf;
  std::unique_ptr<WeightLeaf> weight;
  std::unique_ptr<ColourLeaf> colour;
  VolumeBlock block;  ///< refers to these leaves
};

}  // namespace scanknit
