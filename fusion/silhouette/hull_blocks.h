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
  using ViewOfPart = std::pair<double, std::size_t>;  ///< greatest_m(), and its number
  static constexpr unsigned kPartEdge = 4;            ///< voxels: an eighth of a block
  static constexpr unsigned kPartVoxels = kPartEdge * kPartEdge * kPartEdge;
  [[nodiscard]] Eigen::Vector3d position(const openvdb::Coord& index) const;
  [[nodiscard]] std::optional<std::vector<openvdb::Coord>> in_band(const Eigen::AlignedBox3d& box,
                                                                   std::size_t most) const;
  [[nodiscard]] std::vector<openvdb::Coord> those_in_the_band(const std::vector<openvdb::Coord>& cubes, int edge) const;
  /// look_at() for the part whose first voxel is at `low` in the block. `views`: room for one of each view.
  void look_at_part(const openvdb::Coord& origin, const std::array<unsigned, 3>& low, std::vector<ViewOfPart>& views,
                    std::array<Look, kBlockVoxels>& looks) const;
  /// What view `i` may say at most within a ball; infinite unless it sees all of it.
  [[nodiscard]] double greatest_m(std::size_t i, const Eigen::Vector3d& middle, double radius_m) const;
  /// Adds what view `i` says of some voxels of the block whose first voxel is at `first`.
  void look_from(std::size_t i, const Eigen::Vector3d& first, const std::array<unsigned, kPartVoxels>& voxels,
                 std::array<Look, kBlockVoxels>& looks) const;

  std::span<const SilhouetteView> views_;
  HullCubes cubes_;
  double voxel_size_m_;
  float band_m_;
  std::size_t budget_mib_;
  std::vector<Pose> T_camera_world_;
};

}  // namespace scanknit
