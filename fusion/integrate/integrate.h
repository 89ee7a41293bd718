// Integration: one depth frame enters the volume.
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
  bool is_budget_reached = false;  ///< new blocks were left out: the volume stopped growing
};

/// Updates every observed voxel of the frame's truncation band (and, with carve_free_space, the known voxels in front
/// of it): a weighted running mean (Curless & Levoy 1996). Voxels have one writer each, so the result does not depend
/// on the number of threads. `frame.normals`, when present, give the incidence angle. The pose must be rigid and
/// finite: kInput otherwise, with the volume untouched.
[[nodiscard]] Result<IntegrateStats> integrate(const Frame& frame, const Pose& T_world_camera, TsdfVolume& volume);

/// Counts the blocks that a set of frames would need, without the voxels: for refusing a volume before fusing it.
class BlockCounter {
 public:
  /// Counting stops beyond `max_bytes`.
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
