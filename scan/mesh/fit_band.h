// The largest distance between a mesh's surface and a reading of that surface.
#pragma once

#include "export/picture/surface_fit.h"
#include "fusion/fusion_config.h"

namespace scanknit {

[[nodiscard]] inline FitBand fit_band_of(const FusionConfig& fusion) {
  return {fusion.truncation_voxels * fusion.voxel_size_m, fusion.truncation_sigmas, fusion.noise};
}

}  // namespace scanknit
