// DepthGaps: the voxels near a visual hull that depth never decided.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Geometry>
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/fusion_config.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/volume/block_size.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// Of one block; voxels in the order of their offsets.
struct GapBlock {
  using Voxels = std::bitset<kBlockVoxels>;

  openvdb::Coord origin;
  Voxels inside;                                     ///< unknown to the volume, within the hull, never seen as free
  Voxels around;                                     ///< unknown to the volume, not within the hull
  std::array<float, kBlockVoxels> distance_m{};      ///< to the hull's surface, of both
  std::array<std::uint8_t, kBlockVoxels> seen_by{};  ///< views, of both; 255: as many or more
};

class DepthGaps {
 public:
  /// True where the volume may be filled, a point in the world.
  using MayFill = std::function<bool(const Eigen::Vector3d&)>;

  /// The voxels in `box` that are unknown to the volume (weight 0), seen by kFewestSilhouettes views or more, and in a
  /// block that has a voxel in the band of the hull. `may_fill` may be empty: everywhere; several threads call it at
  /// once. Errors: those of HullBlocks::in_band().
  [[nodiscard]] static Result<DepthGaps> find(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box,
                                              const TsdfVolume& volume, const MayFill& may_fill = {});

  /// Takes out the voxels within the hull that a frame sees as free: the four pixels round the voxel's place in the
  /// picture all have depth, behind the voxel by more than the band in which the frame was fused. Where less is known,
  /// as beside a pixel without return, the frame says nothing.
  void look_through(const DepthImage& depth_m, const CameraIntrinsics& camera, const Pose& T_world_camera);

  [[nodiscard]] std::span<const GapBlock> blocks() const { return blocks_; }
  /// Of all blocks, those within the hull.
  [[nodiscard]] std::size_t voxels_inside() const;

 private:
  explicit DepthGaps(const FusionConfig& config) : config_(config) {}

  FusionConfig config_;
  std::vector<GapBlock> blocks_;
};

}  // namespace scanknit
