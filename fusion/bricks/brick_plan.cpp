#include "fusion/bricks/brick_plan.h"

#include <tbb/parallel_for.h>

#include <new>

#include "fusion/integrate/band_blocks.h"
#include "fusion/integrate/observation.h"

namespace scanknit {

using openvdb::Coord;

Result<void> BrickPlan::add(const Frame& frame, const Pose& T_world_camera) {
  if (!is_rigid(T_world_camera)) return not_rigid();
  try {
    const Observation observation(frame, config_);
    if (!is_indexable(observation, T_world_camera, config_.voxel_size_m)) return too_far_from_origin();
    ++frames_;
    for (const BandBlock& block : find_band_blocks(observation, T_world_camera, config_.voxel_size_m)) {
      Region& region = region_at(region_of(block.origin));
      region.blocks.set(number_in_region(block.origin));
      note_frame(region);
    }
    if (!config_.carve_free_space) return {};
    const SpaceInFront front(observation, T_world_camera, config_.voxel_size_m);
    tbb::parallel_for(std::size_t{0}, regions_.size(), [&](std::size_t i) {
      if (front.meets(regions_[i].origin, kRegionVoxels)) note_frame(regions_[i]);
    });
    return {};
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while planning bricks; a larger fusion.voxel_size needs less"};
  }
}

BrickPlan::Region& BrickPlan::region_at(const Coord& origin) {
  const auto [found, is_new] = places_.try_emplace(origin, regions_.size());
  if (is_new) regions_.push_back({origin, {}, {}});
  return regions_[found->second];
}

/// Of the newest frame.
void BrickPlan::note_frame(Region& region) const {
  if (!region.frames.empty() && region.frames.back().last + 1 >= frames_) {
    region.frames.back().last = frames_;
  } else {
    region.frames.push_back({frames_, frames_});
  }
}

}  // namespace scanknit
