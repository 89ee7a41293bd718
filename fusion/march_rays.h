// Rays of neighbouring pixels through one block of the volume: the inner loop of raycasting.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/camera.h"
#include "core/pixel_rows.h"
#include "core/pose.h"

namespace scanknit {

/// No surface is looked for nearer to the camera than this.
inline constexpr float kNearestSurface_m = 0.05f;

/// From where and along which directions a camera looks, in voxels. The ray of pixel (u, v) is, where its depth is z
/// metres, at start + z R ((u - cx) / fx, (v - cy) / fy, 1).
struct Eye {
  Eye(const CameraIntrinsics& intrinsics, const Pose& T_world_camera, double voxel_size_m);

  std::array<float, 3> start;
  std::array<float, 9> R;  ///< row by row; camera to world, and metres to voxels
  float per_fx, per_fy, cx, cy;
  float voxel_size_m;
};

/// One number for each of eight pixels side by side.
using PixelLanes = std::array<float, kPixelGroup>;

/// The rays of eight pixels side by side, and how far each has come. Where its depth is z metres, a ray is at
/// Eye::start + z step.
struct RayGroup {
  static constexpr float kOver = std::numeric_limits<float>::infinity();

  std::array<PixelLanes, 3> step, per_step;
  PixelLanes voxel_z_m;    ///< the depth in which it passes one voxel's length
  PixelLanes at_z_m;       ///< where it goes on; kOver: it met matter
  PixelLanes outside_z_m;  ///< the last place in free space, if nothing unknown came after it; else 0
  PixelLanes outside_m;    ///< the signed distance there
  PixelLanes matter_z_m;   ///< the place in matter where it ended; 0: it met none
  PixelLanes matter_m;     ///< the signed distance there
};

/// The rays of pixels x to x + 7 of row y, at the beginning of their way.
void aim_rays(const Eye& eye, int x, int y, RayGroup& rays);

/// One block as rays see it: everywhere the value of the nearest sample.
struct BlockField {
  std::array<float, 3> start;  ///< of the rays, from the block's first sample
  const float* tsdf;
  std::array<std::uint32_t, 16> observed;  ///< bit by sample
};

/// Takes `count` groups on through the block. They have passed all that lies in front of it.
void march_rays(const BlockField& block, float voxel_size_m, RayGroup* groups, int count);

}  // namespace scanknit
