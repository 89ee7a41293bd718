#include "fusion/visible_blocks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace scanknit {
namespace {

using openvdb::Coord;

constexpr int kBlockSide = 8;

/// Cubes of samples of one size as the camera sees them; a sample speaks for half a voxel round it.
class CubeProjector {
 public:
  CubeProjector(const CameraIntrinsics& k, const Pose& T_world_camera, double voxel_size_m, int side, float nearest_m)
      : k_(k),
        nearest_m_(nearest_m),
        R_((T_world_camera.linear().transpose() * voxel_size_m).cast<float>()),
        t_(T_world_camera.inverse().translation().cast<float>()),
        half_(0.5f * static_cast<float>(side)),
        fx_(static_cast<float>(k.fx)),
        fy_(static_cast<float>(k.fy)),
        cx_(static_cast<float>(k.cx)),
        cy_(static_cast<float>(k.cy)) {
    for (std::size_t i = 0; i < 8; ++i) {
      corners_[i] = half_ * R_ * Eigen::Vector3f((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
      depth_half_m_ = std::max(depth_half_m_, corners_[i].z());
    }
  }

  /// The pixels that may see the cube whose first sample is `origin`; nothing when none does.
  [[nodiscard]] std::optional<PixelRect> pixels(const Coord& origin) const {
    const Eigen::Vector3f first(static_cast<float>(origin.x()), static_cast<float>(origin.y()),
                                static_cast<float>(origin.z()));
    const Eigen::Vector3f centre = R_ * (first + Eigen::Vector3f::Constant(half_ - 0.5f)) + t_;
    if (centre.z() + depth_half_m_ < nearest_m_) return std::nullopt;
    if (centre.z() - depth_half_m_ < nearest_m_) {  // reaches behind the camera: it may project anywhere
      return PixelRect{0, 0, k_.width - 1, k_.height - 1};
    }
    float x0 = 1e30f, y0 = 1e30f, x1 = -1e30f, y1 = -1e30f;
    for (const Eigen::Vector3f& corner : corners_) {
      const Eigen::Vector3f p = centre + corner;
      const float per_z = 1 / p.z();
      const float x = fx_ * p.x() * per_z + cx_;
      const float y = fy_ * p.y() * per_z + cy_;
      x0 = std::min(x0, x), x1 = std::max(x1, x);
      y0 = std::min(y0, y), y1 = std::max(y1, y);
    }
    // Rounding may move an edge across a pixel's centre.
    constexpr float kSlack = 0.01f;
    const auto clipped = [](float v, int size) { return std::clamp(v, -1.0f, static_cast<float>(size)); };
    const PixelRect rect{std::max(0, static_cast<int>(std::ceil(clipped(x0 - kSlack, k_.width)))),
                         std::max(0, static_cast<int>(std::ceil(clipped(y0 - kSlack, k_.height)))),
                         std::min(k_.width - 1, static_cast<int>(std::floor(clipped(x1 + kSlack, k_.width)))),
                         std::min(k_.height - 1, static_cast<int>(std::floor(clipped(y1 + kSlack, k_.height))))};
    if (rect.x0 > rect.x1 || rect.y0 > rect.y1) return std::nullopt;
    return rect;
  }

 private:
  CameraIntrinsics k_;
  float nearest_m_;
  Eigen::Matrix3f R_;  ///< R_camera_world, and voxels to metres
  Eigen::Vector3f t_;
  float half_;
  float fx_, fy_, cx_, cy_;
  std::array<Eigen::Vector3f, 8> corners_;  ///< from the centre, metres
  float depth_half_m_ = 0;
};

struct Candidate {
  VisibleBlock block;
  int distance;  ///< from the camera's block, the sum over the axes, in blocks
};

std::vector<Candidate> candidates_of(const BlockIndex& index, const CameraIntrinsics& k, const Pose& T_world_camera,
                                     double voxel_size_m, float nearest_m) {
  const CubeProjector regions(k, T_world_camera, voxel_size_m, BlockIndex::kRegionVoxels, nearest_m);
  const CubeProjector blocks(k, T_world_camera, voxel_size_m, kBlockSide, nearest_m);
  const auto own_block = [&](int axis) {
    return static_cast<int>(std::floor((T_world_camera.translation()[axis] / voxel_size_m + 0.5) / kBlockSide));
  };
  const Coord own(own_block(0), own_block(1), own_block(2));

  std::vector<std::vector<Candidate>> found(index.regions().size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t r) {
    const BlockIndex::Region& region = index.regions()[r];
    if (!regions.pixels(region.origin)) return;
    for (const BlockIndex::Number number : region.blocks) {
      const VolumeBlock& block = index.blocks()[number];
      if (!block.has_matter || block.is_free) continue;
      const auto pixels = blocks.pixels(block.origin);
      if (!pixels) continue;
      const Coord away = (block.origin >> 3) - own;
      found[r].push_back({{number, *pixels}, std::abs(away.x()) + std::abs(away.y()) + std::abs(away.z())});
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
