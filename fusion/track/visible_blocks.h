// Which blocks of the volume may hold a surface that a camera sees, nearest first.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/pose.h"
#include "fusion/integrate/depth_pyramid.h"
#include "fusion/volume/block_index.h"

namespace scanknit {

struct VisibleBlock {
  BlockIndex::Number number;
  PixelRect pixels;  ///< within the picture; every pixel whose ray passes the block
};

/// No camera sees farther: the sum over the axes, in blocks. 256 m of voxels of 4 mm.
inline constexpr int kFarthestBlocks = 8000;

/// Blocks with matter that are not all free space, at least partly `nearest_m` before the camera. A ray leaves a block
/// through one of its faces, away from the camera's own block along each axis: in the order of the sum of these
/// distances, counted in blocks, every ray meets its blocks front to back. Blocks of one sum share no ray.
[[nodiscard]] std::vector<VisibleBlock> visible_blocks(const BlockIndex& index, const CameraIntrinsics& intrinsics,
                                                       const Pose& T_world_camera, double voxel_size_m,
                                                       float nearest_m);

}  // namespace scanknit
