// Finds the blocks of 8^3 voxels that a frame updates.
#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "fusion/integrate/cube_projector.h"
#include "fusion/integrate/observation.h"
#include "fusion/volume/region_set.h"

namespace scanknit {

/// Projects cubes of samples into the picture: the rectangle of all pixels next to a sample's projection, clipped to
/// the picture.
class SampleProjector {
 public:
  SampleProjector(const CameraIntrinsics& intrinsics, const Pose& T_world_camera, double voxel_size_m)
      : projector_(intrinsics, T_world_camera, voxel_size_m), width_(intrinsics.width), height_(intrinsics.height) {}

  struct View {
    PixelRect pixels;
    DepthRange z;
  };
  /// Nothing when no sample is in front of the camera.
  [[nodiscard]] std::optional<View> view(const openvdb::Coord& origin, int side) const;
  /// The views of the eight octants of a cube; each has `side` samples along an edge; see CubeViews.
  [[nodiscard]] std::array<std::optional<View>, 8> views(const openvdb::Coord& origin, int side) const;

 private:
  [[nodiscard]] std::optional<View> view_of(const CubeView& cube) const;

  CubeProjector projector_;
  int width_, height_;
};

/// False when the frame's voxel indices would leave the 32-bit range (a pose thousands of kilometres away).
[[nodiscard]] bool is_indexable(const Observation& observation, const Pose& T_world_camera, double voxel_size_m);

/// Of a frame that is not indexable, and of one whose pose is not rigid (kInput).
[[nodiscard]] Error too_far_from_origin();
[[nodiscard]] Error not_rigid();

struct BandBlock {
  openvdb::Coord origin;
  float far_m;  ///< the frame has no observation of the block behind this z
};

/// All blocks, in Morton order, whose cube of samples meets the truncation band of some pixel, and few others: an
/// octree over the camera's frustum, pruned where the pyramid of bands is empty. It follows no rays and misses no
/// block. The frame must be indexable. `part`: only the blocks of these regions; null: of all.
[[nodiscard]] std::vector<BandBlock> find_band_blocks(const Observation& observation, const Pose& T_world_camera,
                                                      double voxel_size_m, const RegionSet* part = nullptr);

/// Finds cubes that hold space in front of a frame's band, which carving updates.
class SpaceInFront {
 public:
  /// Both references outlive it.
  SpaceInFront(const Observation& observation, const Pose& T_world_camera, double voxel_size_m)
      : observation_(observation), projector_(observation.intrinsics(), T_world_camera, voxel_size_m) {}

  /// True if some pixel's band begins behind the front of the cube of `side`^3 samples; and for few others.
  [[nodiscard]] bool meets(const openvdb::Coord& origin, int side) const;

 private:
  const Observation& observation_;
  SampleProjector projector_;
};

}  // namespace scanknit
