// BrickPlan: which part of space each frame changes, known before anything is fused.
#pragma once

#include <openvdb/openvdb.h>

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/region_set.h"

namespace scanknit {

/// Frames with successive numbers, from 1.
struct FrameRun {
  std::uint32_t first = 0, last = 0;  ///< both included

  bool operator==(const FrameRun&) const = default;
};

class BrickPlan {
 public:
  /// A cube of kRegionVoxels^3 voxels in which some frame may observe something.
  struct Region {
    openvdb::Coord origin;         ///< its lowest voxel
    BlocksOfRegion blocks;         ///< that frames may observe
    std::vector<FrameRun> frames;  ///< that may change a block of the region, ascending

    /// Calls visit(origin) for each of the blocks.
    template <typename Visit>
    void for_each_block(const Visit& visit) const;
  };

  explicit BrickPlan(const FusionConfig& config) : config_(config) {}

  /// The next frame, filtered as for integrate(). Errors: those of integrate(), which does not fuse it either; it gets
  /// no number then.
  [[nodiscard]] Result<void> add(const Frame& frame, const Pose& T_world_camera);

  /// The number of frames, which is the number of the last one.
  [[nodiscard]] std::uint32_t frames() const { return frames_; }
  /// In the order in which frames came to them. Takes about 350 bytes for each, and 8 for each run of frames.
  [[nodiscard]] std::span<const Region> regions() const { return regions_; }

 private:
  [[nodiscard]] Region& region_at(const openvdb::Coord& origin);
  void note_frame(Region& region) const;

  FusionConfig config_;
  std::uint32_t frames_ = 0;
  std::vector<Region> regions_;
  std::unordered_map<openvdb::Coord, std::size_t> places_;  ///< of regions, by their origins
};

template <typename Visit>
void BrickPlan::Region::for_each_block(const Visit& visit) const {
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i]) visit(block_of(origin, i));
  }
}

}  // namespace scanknit
