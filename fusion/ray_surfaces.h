// The surfaces that rays met, by the field between samples.
#pragma once

#include <array>

#include "fusion/march_rays.h"
#include "fusion/voxel_reader.h"

namespace scanknit {

/// What eight pixels side by side see. Without a surface: depth 0, the rest is undefined.
struct SeenGroup {
  PixelLanes depth_m;
  std::array<PixelLanes, 3> gradient;  ///< of the signed distance, along the world's axes, metres a voxel
  PixelLanes intensity;                ///< luma of the mean colour, 0 to 1; negative where none is known
};

/// Where the trilinear signed distance is zero between a ray's last place in free space and its first in matter: from
/// a guess by the samples nearest to these two, by two steps of Newton's method. No surface where a ray came from
/// behind, where a sample needed is unknown, or where the field is too rough for the steps to agree.
void find_surfaces(const Eye& eye, RayGroup& rays, VoxelReader& voxels, SeenGroup& seen);

/// Fills in the intensity of what was found.
void find_intensities(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, SeenGroup& seen);

/// Asks the memory for what find_intensities will read: worth while for a tile before it is looked at.
void prefetch_intensities(const Eye& eye, const RayGroup& rays, VoxelReader& voxels, const SeenGroup& seen);

}  // namespace scanknit
