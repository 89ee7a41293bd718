// Rays of neighbouring pixels through one block of the volume: the inner loop of raycasting.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/camera.h"
#include "core/pose.h"
#include "fusion/turntable/picture_part.h"

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

/// Rays are followed in patches of 4 x 4 pixels.
inline constexpr int kPatchSide = 4;
inline constexpr std::size_t kPatchRays = kPatchSide * kPatchSide;

/// One number for each ray of a patch, row by row.
using RayLanes = std::array<float, kPatchRays>;
/// One bit for each.
using RayBits = std::uint16_t;
inline constexpr RayBits kAllRays = 0xFFFF;

/// The rays of a patch, and how far each has come. Where its depth is z metres, a ray is at Eye::start + z step.
struct alignas(64) RayPatch {
  static constexpr float kOver = std::numeric_limits<float>::infinity();

  std::array<RayLanes, 3> step, per_step;
  RayLanes voxel_z_m;    ///< the depth in which it passes one voxel's length
  RayLanes at_z_m;       ///< where it goes on; kOver: it met matter
  RayLanes outside_z_m;  ///< the last place in free space, if nothing unknown came after it; else 0
  RayLanes outside_m;    ///< the signed distance there
  RayLanes matter_z_m;   ///< the place in matter where it ended; 0: it met none
  RayLanes matter_m;     ///< the signed distance there
};

/// The rays of a patch that lie in a rectangle, which it meets; all counted from the tile's first pixel.
[[nodiscard]] constexpr RayBits rays_within(const PixelRect& pixels, int across, int down) {
  const auto bits = [](int first, int last, int begin) {
    const unsigned from = 0xFu << (first > begin ? first - begin : 0);
    const unsigned to = 0xFu >> (last < begin + 3 ? begin + 3 - last : 0);
    return from & to;
  };
  const unsigned columns = bits(pixels.x0, pixels.x1, kPatchSide * across);
  const unsigned rows = bits(pixels.y0, pixels.y1, kPatchSide * down);
  const unsigned one_a_row = (rows & 1) | (rows & 2) << 3 | (rows & 4) << 6 | (rows & 8) << 9;
  return static_cast<RayBits>(one_a_row * columns);
}

/// Neighbouring patches, and which of their rays have met no matter yet.
struct RayTile {
  static constexpr int kAcross = 8;  ///< patches
  static constexpr int kDown = 4;
  static constexpr int kWidth = kAcross * kPatchSide;  ///< pixels
  static constexpr int kHeight = kDown * kPatchSide;

  std::array<RayPatch, kAcross * kDown> patches;
  std::array<RayBits, kAcross * kDown> open;

  [[nodiscard]] static std::size_t number_of(int across, int down) {
    return static_cast<std::size_t>(down * kAcross + across);
  }
  /// Is a ray of `pixels`, counted from the tile's first, open?
  [[nodiscard]] bool is_open(const PixelRect& pixels) const {
    for (int down = pixels.y0 / kPatchSide; down <= pixels.y1 / kPatchSide; ++down) {
      for (int across = pixels.x0 / kPatchSide; across <= pixels.x1 / kPatchSide; ++across) {
        if ((open[number_of(across, down)] & rays_within(pixels, across, down)) != 0) return true;
      }
    }
    return false;
  }
};

/// The rays whose first pixel is (x, y), at the beginning of their way.
void aim_rays(const Eye& eye, int x, int y, RayTile& tile);

/// One block as rays see it: everywhere the value of the nearest sample.
struct BlockField {
  std::array<float, 3> start;  ///< of the rays, from the block's first sample
  const float* tsdf;           ///< NaN: unknown
};

/// Takes the open rays of `pixels`, counted from the tile's first, on through the block. They have passed all that lies
/// in front of it. True if one of them met matter.
bool march_rays(const BlockField& block, float voxel_size_m, const PixelRect& pixels, RayTile& tile);

}  // namespace scanknit
