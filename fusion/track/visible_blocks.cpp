#include "fusion/track/visible_blocks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "fusion/integrate/cube_projector.h"
#include "fusion/volume/block_size.h"

namespace scanknit {
namespace {

using openvdb::Coord;

/// The pixels whose rays may pass a cube of samples, each of which speaks for half a voxel round it; nothing when none
/// does.
class RayFinder {
 public:
  RayFinder(const CameraIntrinsics& k, const Pose& T_world_camera, double voxel_size_m, float nearest_m)
      : projector_(k, T_world_camera, voxel_size_m), width_(k.width), height_(k.height), nearest_m_(nearest_m) {}

  [[nodiscard]] std::optional<PixelRect> pixels(const Coord& origin, int side) const {
    const CubeView view = projector_.view(origin, -0.5f, static_cast<float>(side));
    if (view.far_m < nearest_m_) return std::nullopt;
    if (view.reaches_behind(nearest_m_)) {
      if (projector_.is_beside(origin, -0.5f, static_cast<float>(side), width_, height_)) return std::nullopt;
      return PixelRect{0, 0, width_ - 1, height_ - 1};
    }
    const auto first = [](float low, int size) {
      return static_cast<int>(std::ceil(std::clamp(low, 0.0f, static_cast<float>(size))));
    };
    const auto last = [](float high, int size) {
      return static_cast<int>(std::floor(std::clamp(high, -1.0f, static_cast<float>(size - 1))));
    };
    const PixelRect rect{first(view.x0, width_), first(view.y0, height_), last(view.x1, width_),
                         last(view.y1, height_)};
    if (rect.x0 > rect.x1 || rect.y0 > rect.y1) return std::nullopt;
    return rect;
  }

 private:
  CubeProjector projector_;
  int width_, height_;
  float nearest_m_;
};

struct Candidate {
  VisibleBlock block;
  int distance;  ///< from the camera's block, the sum over the axes, in blocks
};

std::vector<Candidate> candidates_of(const BlockIndex& index, const CameraIntrinsics& k, const Pose& T_world_camera,
                                     double voxel_size_m, float nearest_m) {
  const RayFinder rays(k, T_world_camera, voxel_size_m, nearest_m);
  const auto own_block = [&](int axis) {
    return static_cast<int>(std::floor((T_world_camera.translation()[axis] / voxel_size_m + 0.5) / kBlockEdgeVoxels));
  };
  const Coord own(own_block(0), own_block(1), own_block(2));

  std::vector<std::vector<Candidate>> found(index.regions().size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t r) {
    const BlockIndex::Region& region = *index.regions()[r];
    if (!rays.pixels(region.origin, BlockIndex::kRegionVoxels)) return;
    for (const BlockIndex::Number number : region.blocks) {
      const VolumeBlock& block = index.blocks()[number];
      if (!block.has_matter || block.is_free) continue;
      const auto pixels = rays.pixels(block.origin, kBlockEdgeVoxels);
      if (!pixels) continue;
      const Coord away = (block.origin >> 3) - own;
      const int distance = std::abs(away.x()) + std::abs(away.y()) + std::abs(away.z());
      if (distance < kFarthestBlocks) found[r].push_back({{number, *pixels}, distance});
    }
  });
  std::vector<Candidate> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

std::vector<VisibleBlock> visible_blocks(const BlockIndex& index, const CameraIntrinsics& k, const Pose& T_world_camera,
                                         double voxel_size_m, float nearest_m) {
  const std::vector<Candidate> candidates = candidates_of(index, k, T_world_camera, voxel_size_m, nearest_m);
  // Sorted by counting: what comes before the first block of each distance.
  std::vector<std::size_t> first(1, 0);
  for (const Candidate& candidate : candidates) {
    const auto distance = static_cast<std::size_t>(candidate.distance);
    if (first.size() < distance + 2) first.resize(distance + 2, 0);
    ++first[distance + 1];
  }
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<VisibleBlock> sorted(candidates.size());
  for (const Candidate& candidate : candidates) {
    sorted[first[static_cast<std::size_t>(candidate.distance)]++] = candidate.block;
  }
  return sorted;
}

}  // namespace scanknit
