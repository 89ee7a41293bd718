// Integrates one depth frame into the volume.
#pragma once

#include <cstddef>
#include <unordered_set>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/tsdf_volume.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {

struct IntegrateStats {
  std::size_t blocks_touched = 0;
  std::size_t blocks_added = 0;
  bool is_budget_reached = false;  ///< new blocks were not added: the volume stopped growing
};

/// Updates every observed voxel of the frame's truncation band (and, with carve_free_space, the known voxels in front
/// of it): a weighted running mean (Curless & Levoy 1996). Each voxel has one writer, so that the result does not
/// depend on the number of threads. `frame.normals`, if present, give the incidence angle. Error kInput: the pose is
/// not rigid and finite; the volume is unchanged.
[[nodiscard]] Result<IntegrateStats> integrate(const Frame& frame, const Pose& T_world_camera, TsdfVolume& volume);

/// Counts the blocks that a set of frames needs, without allocating voxels, to refuse a volume before fusing it.
class BlockCounter {
 public:
  /// Stops counting beyond `max_bytes`.
  BlockCounter(const FusionConfig& config, std::size_t max_bytes);
  void add(const Frame& frame, const Pose& T_world_camera);
  [[nodiscard]] std::size_t blocks() const;
  [[nodiscard]] bool is_full() const { return memory_.most_bytes() > max_bytes_; }

 private:
  FusionConfig config_;
  std::size_t max_bytes_;
  std::unordered_set<openvdb::Coord> origins_;
  VolumeMemory memory_;
};

}  // namespace scanknit
