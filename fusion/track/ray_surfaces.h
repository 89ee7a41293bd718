// The surfaces that rays met, by the field between samples.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fusion/track/block_copies.h"
#include "fusion/track/march_rays.h"

namespace scanknit {

/// What the pixels of a patch see. Without a surface: depth 0, normal zero, intensity -1.
struct alignas(64) SeenPatch {
  RayLanes depth_m;
  std::array<RayLanes, 3> normal;  ///< unit, camera frame, towards the camera
  RayLanes intensity;              ///< luma of the mean colour, 0 to 1; negative where none is known
};

/// Where the trilinear signed distance is zero between a ray's last place in free space and its first in matter: from
/// a guess by the samples nearest to these two, by two steps of Newton's method. No surface where a ray came from
/// behind, where a sample needed is unknown, or where the field is too rough for the steps to agree.
void find_surfaces(const Eye& eye, const Eigen::Matrix3f& R_camera_world, const RayPatch& rays, TileSamples& samples,
                   SeenPatch& seen);

}  // namespace scanknit
