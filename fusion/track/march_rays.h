// Follows rays of neighbouring pixels through one block of the volume: the inner loop of raycasting.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/camera.h"
#include "core/pose.h"
#include "fusion/picture_part.h"

namespace scanknit {

/// Rays ignore surfaces nearer to the camera than this.
inline constexpr float kNearestSurface_m = 0.05f;

/// A camera's position and directions, in voxels. The ray of pixel (u, v) has at a depth of z metres the position start
/// + z R ((u - cx) / fx, (v - cy) / fy, 1).
struct Eye {
  Eye(const CameraIntrinsics& intrinsics, const Pose& T_world_camera, double voxel_size_m);

  std::array<float, 3> start;
  std::array<float, 9> R;  ///< row by row; camera to world, and metres to voxels
  float per_fx, per_fy, cx, cy;
  float voxel_size_m;
};

/// Rays are processed in patches of 4 x 4 pixels.
inline constexpr int kPatchSide = 4;
inline constexpr std::size_t kPatchRays = kPatchSide * kPatchSide;

/// One number for each ray of a patch, row by row.
using RayLanes = std::array<float, kPatchRays>;
/// One bit for each ray of a patch.
using RayBits = std::uint16_t;
inline constexpr RayBits kAllRays = 0xFFFF;

/// The rays of a patch, and their progress. At a depth of z metres, a ray has the position Eye::start + z step.
struct alignas(64) RayPatch {
  static constexpr float kOver = std::numeric_limits<float>::infinity();

  std::array<RayLanes, 3> step, per_step;
  RayLanes voxel_z_m;    ///< the depth over which it passes one voxel's length
  RayLanes at_z_m;       ///< current depth; kOver: it has met matter
  RayLanes outside_z_m;  ///< the last depth in free space, if nothing unknown came after it; else 0
  RayLanes outside_m;    ///< the signed distance there
  RayLanes matter_z_m;   ///< the depth in matter where it ended; 0: it has met none
  RayLanes matter_m;     ///< the signed distance there
};

/// The rays of a patch that are in a rectangle, which meets the patch; all coordinates from the tile's first pixel.
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

/// Neighbouring patches, and their open rays, which have met no matter yet.
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
  /// True if a ray of `pixels`, counted from the tile's first, is open.
  [[nodiscard]] bool is_open(const PixelRect& pixels) const {
    for (int down = pixels.y0 / kPatchSide; down <= pixels.y1 / kPatchSide; ++down) {
      for (int across = pixels.x0 / kPatchSide; across <= pixels.x1 / kPatchSide; ++across) {
        if ((open[number_of(across, down)] & rays_within(pixels, across, down)) != 0) return true;
      }
    }
    return false;
  }
};

/// Sets the rays of the tile with the first pixel (x, y) to their starts.
void aim_rays(const Eye& eye, int x, int y, RayTile& tile);

/// One block for rays: the field has everywhere the value of the nearest sample.
struct BlockField {
  std::array<float, 3> start;  ///< start of the rays, relative to the block's first sample
  const float* tsdf;           ///< NaN: unknown
};

/// Moves the open rays of `pixels`, counted from the tile's first, through the block. They must have passed everything
/// in front of it. True if one of them met matter.
bool march_rays(const BlockField& block, float voxel_size_m, const PixelRect& pixels, RayTile& tile);

}  // namespace scanknit
