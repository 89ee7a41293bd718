#include "fusion/bricks/brick_plan.h"

#include <tbb/parallel_for.h>

#include <bit>
#include <functional>
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
      const Coord at = (block.origin - region.origin) >> 3;
      region.blocks.set(static_cast<std::size_t>(64 * at.x() + 8 * at.y() + at.z()));
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

std::uint64_t BrickPlan::checksum() const {
  std::uint64_t sum = 0xCBF29CE484222325u;  // FNV-1a (Fowler, Noll, Vo 1991), by words
  const auto add = [&](std::uint64_t word) { sum = (sum ^ word) * 0x100000001B3u; };
  for (const double setting :
       {config_.voxel_size_m, config_.truncation_voxels, config_.truncation_sigmas, config_.noise.floor_m,
        config_.noise.growth_per_m, config_.noise.from_m, config_.max_weight, config_.carve_free_space ? 1.0 : 0.0}) {
    add(std::bit_cast<std::uint64_t>(setting));
  }
  add(frames_);
  for (const Region& region : regions_) {
    for (int axis = 0; axis < 3; ++axis) add(static_cast<std::uint32_t>(region.origin[axis]));
    add(std::hash<std::bitset<512>>()(region.blocks));
    for (const FrameRun& run : region.frames) add(std::uint64_t{run.first} << 32 | run.last);
  }
  return sum;
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
