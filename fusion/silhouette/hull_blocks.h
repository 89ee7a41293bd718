// HullBlocks: the blocks of a volume that the surface of a visual hull comes near, and the distances at their voxels.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "fusion/silhouette/hull_cubes.h"
#include "fusion/silhouette/silhouette.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/volume/block_size.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// With the voxels and the band of a volume, of which nothing else is used.
class HullBlocks {
 public:
  /// `views` outlive it; their silhouettes reach as far as the band where the hull can be.
  HullBlocks(std::span<const SilhouetteView> views, const TsdfVolume& volume);

  /// The origins of the blocks within `box` that the band may meet, in a fixed order. Errors: kInput for a box that is
  /// too far from the world's origin; kBudget for several times as many as fusion.memory_budget has room for.
  [[nodiscard]] Result<std::vector<openvdb::Coord>> in_band(const Eigen::AlignedBox3d& box) const;

  /// What the views say of one voxel.
  struct Look {
    float distance_m = 0;  ///< to the hull's surface: the greatest of the views, between the band's ends
    int seen_by = 0;       ///< views; with fewer than kFewestSilhouettes the voxel is unknown
  };
  /// Of a block's voxels, in the order of their offsets.
  [[nodiscard]] std::array<Look, kBlockVoxels> look_at(const openvdb::Coord& origin) const;

 private:
  using ViewOfBlock = std::pair<double, std::size_t>;  ///< the greatest distance that it may see there, and its number
  [[nodiscard]] Eigen::Vector3d position(const openvdb::Coord& index) const;
  [[nodiscard]] std::optional<std::vector<openvdb::Coord>> in_band(const Eigen::AlignedBox3d& box,
                                                                   std::size_t most) const;
  [[nodiscard]] std::vector<openvdb::Coord> those_in_the_band(const std::vector<openvdb::Coord>& cubes, int edge) const;
  /// Adds what view `i` says of the block's voxels, the first of which is at `first`.
  void look_from(std::size_t i, const Eigen::Vector3d& first, std::array<Look, kBlockVoxels>& looks) const;

  std::span<const SilhouetteView> views_;
  HullCubes cubes_;
  double voxel_size_m_;
  float band_m_;
  std::size_t budget_mib_;
  std::vector<Pose> T_camera_world_;
};

}  // namespace scanknit
