// Cutting a fused volume to the space in which an object turned, and closing it where it stood.
#pragma once

#include "fusion/turntable/turntable_space.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

struct VolumeCut {
  bool has_base = false;  ///< the object's underside is a plane at the disc, made not seen
  double base_m2 = 0;     ///< its area
};

/// What is outside of the space becomes unknown, and so does the disc. With `closes_base`, the walls go on straight
/// down to the disc from a little above it, where the disc's own surface no longer disturbs them, and a plane at the
/// disc closes what they enclose there; where they enclose nothing, nothing is made. Without a disc that was seen, only
/// the outside is cut.
[[nodiscard]] VolumeCut cut_volume(const TurntableSpace& space, bool closes_base, TsdfVolume& volume);

}  // namespace scanknit
