// Finds the surfaces that rays met, in the field between samples.
#pragma once

#include <Eigen/Core>
#include <array>

#include "fusion/track/block_copies.h"
#include "fusion/track/march_rays.h"

namespace scanknit {

/// The surfaces at the pixels of a patch. Without a surface: depth 0, normal zero, intensity -1.
struct alignas(64) SeenPatch {
  RayLanes depth_m;
  std::array<RayLanes, 3> normal;  ///< unit, camera frame, towards the camera
  RayLanes intensity;              ///< luma of the mean colour, 0 to 1; negative if it is unknown
};

/// Finds the zero of the trilinear signed distance between a ray's last position in free space and its first in matter:
/// starts from the samples nearest to these two, and makes two steps of Newton's method. No surface if the ray came
/// from behind, if a needed sample is unknown, or if the field is too rough for the steps to agree.
void find_surfaces(const Eye& eye, const Eigen::Matrix3f& R_camera_world, const RayPatch& rays, TileSamples& samples,
                   SeenPatch& seen);

}  // namespace scanknit
