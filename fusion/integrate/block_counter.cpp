#include "fusion/integrate/block_counter.h"

#include "fusion/integrate/band_blocks.h"
#include "fusion/integrate/observation.h"

namespace scanknit {

BlockCounter::BlockCounter(const FusionConfig& config, std::size_t max_bytes)
    : config_(config), max_bytes_(max_bytes) {}

void BlockCounter::add(const Frame& frame, const Pose& T_world_camera) {
  if (is_full() || !is_rigid(T_world_camera)) return;
  const Observation observation(frame, config_);
  if (!is_indexable(observation, T_world_camera, config_.voxel_size_m)) return;
  for (const BandBlock& block : find_band_blocks(observation, T_world_camera, config_.voxel_size_m)) {
    if (is_full()) return;
    if (origins_.insert(block.origin).second) memory_.add(block.origin);
  }
}

std::size_t BlockCounter::blocks() const {
  return origins_.size();
}

}  // namespace scanknit
