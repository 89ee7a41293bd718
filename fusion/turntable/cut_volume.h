// Cuts a fused volume to the space in which an object turned, and closes the object where it stood.
#pragma once

#include <Eigen/Core>

#include "fusion/fusion_config.h"
#include "fusion/turntable/turntable_space.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

struct VolumeCut {
  bool has_base = false;  ///< the object's underside is a plane at the disc, which was not observed
  double base_m2 = 0;     ///< its area
};

/// True for a point that cut_volume() leaves as it was observed: within the space, and clear of the disc.
[[nodiscard]] bool is_kept(const TurntableSpace& space, const FusionConfig& config, const Eigen::Vector3d& p);

/// Makes everything outside of the space unknown, and the disc too. With `closes_base`, extends the walls straight down
/// to the disc from a little above it, where the disc's own surface does not disturb them, and closes what they enclose
/// by a plane at the disc; does nothing if they enclose nothing. If no disc was seen, only cuts the outside.
[[nodiscard]] VolumeCut cut_volume(const TurntableSpace& space, bool closes_base, TsdfVolume& volume);

}  // namespace scanknit
