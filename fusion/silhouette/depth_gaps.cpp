#include "fusion/silhouette/depth_gaps.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "fusion/silhouette/hull_blocks.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

/// The place of a block's voxel in the world.
class VoxelPlaces {
 public:
  VoxelPlaces(const Coord& origin, double voxel_size_m)
      : first_(Vector3d(origin.x(), origin.y(), origin.z()) * voxel_size_m), voxel_size_m_(voxel_size_m) {}

  [[nodiscard]] Vector3d operator[](std::size_t n) const {
    const auto offset = static_cast<unsigned>(n);
    return first_ + Vector3d(offset >> 6, offset >> 3 & 7, offset & 7) * voxel_size_m_;
  }

 private:
  Vector3d first_;
  double voxel_size_m_;
};

/// The voxels that the volume does not know.
GapBlock::Voxels unknown_voxels(const Coord& origin, const TsdfVolume& volume) {
  GapBlock::Voxels unknown;
  unknown.set();
  const BlockIndex::Number number = volume.index().find(origin);
  if (number == BlockIndex::kNone) return unknown;
  const WeightCode* weights = volume.index().blocks()[number].weight->buffer().data();
  for (std::size_t n = 0; n < kBlockVoxels; ++n) unknown[n] = weights[n] == 0;
  return unknown;
}

/// True if a voxel that enough views see is in the hull's band.
bool is_near_surface(const std::array<HullBlocks::Look, kBlockVoxels>& looks, float band_m) {
  return std::any_of(looks.begin(), looks.end(), [&](const auto& look) {
    return look.seen_by >= kFewestSilhouettes && std::abs(look.distance_m) < band_m;
  });
}

/// Without voxels if there is no gap in the block, or no voxel in the hull's band, as in carve_hull().
GapBlock gaps_of(const Coord& origin, const HullBlocks& hull, const TsdfVolume& volume,
                 const DepthGaps::MayFill& may_fill) {
  GapBlock block{.origin = origin, .inside = {}, .around = {}};
  const GapBlock::Voxels unknown = unknown_voxels(origin, volume);
  if (unknown.none()) return block;
  constexpr int kMostViews = std::numeric_limits<std::uint8_t>::max();
  const auto looks = hull.look_at(origin);
  if (!is_near_surface(looks, volume.tsdf().background())) return block;
  const VoxelPlaces places(origin, volume.config().voxel_size_m);
  for (std::size_t n = 0; n < kBlockVoxels; ++n) {
    if (!unknown[n] || looks[n].seen_by < kFewestSilhouettes) continue;
    if (may_fill && !may_fill(places[n])) continue;
    block.distance_m[n] = looks[n].distance_m;
    block.seen_by[n] = static_cast<std::uint8_t>(std::min(looks[n].seen_by, kMostViews));
    (looks[n].distance_m < 0 ? block.inside : block.around).set(n);
  }
  return block;
}

/// The least depth of the four pixels round a place in the picture; 0 where one has none.
float least_depth_round(const DepthImage& depth_m, const Eigen::Vector2d& pixel) {
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < depth_m.width() - 1 && pixel.y() < depth_m.height() - 1)) {
    return 0;
  }
  const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
  return std::min({depth_m.at(x, y), depth_m.at(x + 1, y), depth_m.at(x, y + 1), depth_m.at(x + 1, y + 1)});
}

}  // namespace

Result<DepthGaps> DepthGaps::find(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box,
                                  const TsdfVolume& volume, const MayFill& may_fill) {
  const HullBlocks hull(views, volume);
  const auto origins = hull.in_band(box);
  if (!origins) return origins.error();
  std::vector<GapBlock> blocks(origins->size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      blocks[i] = gaps_of((*origins)[i], hull, volume, may_fill);
    }
  });
  std::erase_if(blocks, [](const GapBlock& block) { return block.inside.none() && block.around.none(); });
  DepthGaps gaps(volume.config());
  gaps.blocks_ = std::move(blocks);
  return gaps;
}

void DepthGaps::look_through(const DepthImage& depth_m, const CameraIntrinsics& camera, const Pose& T_world_camera) {
  const Pose T_camera_world = T_world_camera.inverse();
  const double band_m = config_.truncation_voxels * config_.voxel_size_m;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks_.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      GapBlock& block = blocks_[i];
      if (block.inside.none()) continue;
      const VoxelPlaces places(block.origin, config_.voxel_size_m);
      for (std::size_t n = 0; n < kBlockVoxels; ++n) {
        if (!block.inside[n]) continue;
        const Vector3d in_camera = T_camera_world * places[n];
        if (!(in_camera.z() > 0)) continue;
        const double seen_m = double{least_depth_round(depth_m, camera.project(in_camera))};
        if (!(seen_m > 0)) continue;
        const double reach_m = std::max(band_m, config_.truncation_sigmas * config_.noise.sigma_m(seen_m));
        if (in_camera.z() + reach_m < seen_m) block.inside.reset(n);
      }
    }
  });
}

std::size_t DepthGaps::voxels_inside() const {
  std::size_t voxels = 0;
  for (const GapBlock& block : blocks_) voxels += block.inside.count();
  return voxels;
}

}  // namespace scanknit
