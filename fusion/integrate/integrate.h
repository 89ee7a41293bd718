// Integrates one depth frame into the volume.
#pragma once

#include <cstddef>

#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"

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

}  // namespace scanknit
