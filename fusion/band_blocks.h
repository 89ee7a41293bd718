// Which blocks of 8^3 voxels a frame concerns.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "core/pose.h"
#include "fusion/observation.h"

namespace scanknit {

/// A box of voxel samples seen from a camera, conservatively: the box of its 8 turned corners.
struct BoxView {
  bool is_in_front = false;  ///< some of it has z > 0
  PixelRect pixels{};        ///< every pixel beside a sample's projection
  DepthRange z{};
};

/// Turns boxes of samples (index space, ends included) into views.
class BoxProjector {
 public:
  BoxProjector(const CameraIntrinsics& intrinsics, const Pose& T_world_camera, double voxel_size_m);
  [[nodiscard]] BoxView view(const openvdb::Coord& first, const openvdb::Coord& last) const;

 private:
  CameraIntrinsics intrinsics_;
  Pose T_camera_world_;
  Eigen::Matrix3d abs_rotation_;
  double voxel_size_m_;
};

/// False when the frame's voxel indices would leave the 32-bit range (a pose thousands of kilometres away).
[[nodiscard]] bool is_indexable(const Observation& observation, const Pose& T_world_camera, double voxel_size_m);

/// The origins (multiples of 8, in Morton order) of all blocks whose box of samples meets the truncation band of some
/// pixel: an octree over the camera's frustum, cut where the pyramid of bands shows nothing. No ray is walked; no block
/// is missed. The frame must be indexable.
[[nodiscard]] std::vector<openvdb::Coord> find_band_blocks(const Observation& observation, const Pose& T_world_camera,
                                                           double voxel_size_m);

}  // namespace scanknit
