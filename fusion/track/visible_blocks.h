// Finds the blocks of the volume that may have a surface visible to a camera, nearest first.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/pose.h"
#include "fusion/integrate/depth_pyramid.h"
#include "fusion/volume/block_index.h"

namespace scanknit {

struct VisibleBlock {
  BlockIndex::Number number;
  PixelRect pixels;  ///< all pixels of the picture whose ray may pass the block
};

/// The farthest visible block: the sum of distances along the axes, in blocks. 256 m for voxels of 4 mm.
inline constexpr int kFarthestBlocks = 8000;

/// Blocks with matter that are not all free space and are at least partly more than `nearest_m` in front of the camera.
/// The order is the sum of the distances from the camera's block along the three axes, in blocks. Every ray leaves a
/// block away from the camera's block, so it meets its blocks in this order, front to back. Blocks with the same sum
/// share no ray.
[[nodiscard]] std::vector<VisibleBlock> visible_blocks(const BlockIndex& index, const CameraIntrinsics& intrinsics,
                                                       const Pose& T_world_camera, double voxel_size_m,
                                                       float nearest_m);

}  // namespace scanknit
