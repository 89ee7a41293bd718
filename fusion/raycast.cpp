#include "fusion/raycast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "fusion/march_rays.h"
#include "fusion/ray_surfaces.h"
#include "fusion/visible_blocks.h"
#include "fusion/voxel_reader.h"

namespace scanknit {
namespace {

constexpr std::size_t kCacheLine = 64;

/// The distances of the blocks that a tile's rays pass fit into a core's own cache.
constexpr int kTileRows = 16;
constexpr int kTileGroups = 4;
constexpr int kTileWidth = kTileGroups * kPixelGroup;
constexpr std::size_t kGroups = kTileRows * kTileGroups;

/// Some neighbouring pixels.
class Tile {
 public:
  Tile(const BlockIndex& index, const Eye& eye, const PixelRect& pixels)
      : index_(index), eye_(eye), pixels_(pixels), voxels_(index) {
    for (int y = pixels_.y0; y <= pixels_.y1; ++y) {
      for (int across = 0; across < kTileGroups; ++across) {
        aim_rays(eye, pixels_.x0 + across * kPixelGroup, y, groups_[number_of(across, y)]);
      }
    }
  }

  void march(std::span<const VisibleBlock> own) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      prefetch(own, i);
      march(own[i]);
    }
  }

  void show(const Eigen::Matrix3f& R_camera_world, ModelView& view) {
    std::array<SeenGroup, kGroups> seen;
    const std::size_t groups = static_cast<std::size_t>(kTileGroups * (pixels_.y1 - pixels_.y0 + 1));
    for (std::size_t i = 0; i < groups; ++i) {
      find_surfaces(eye_, groups_[i], voxels_, seen[i]);
      prefetch_intensities(eye_, groups_[i], voxels_, seen[i]);
    }
    for (std::size_t i = 0; i < groups; ++i) find_intensities(eye_, groups_[i], voxels_, seen[i]);
    for (int y = pixels_.y0; y <= pixels_.y1; ++y) {
      for (int x = pixels_.x0; x <= pixels_.x1; ++x)
        show(seen[number_of((x - pixels_.x0) / kPixelGroup, y)], x, y, R_camera_world, view);
    }
  }

 private:
  [[nodiscard]] std::size_t number_of(int across, int y) const {
    return static_cast<std::size_t>((y - pixels_.y0) * kTileGroups + across);
  }

  [[nodiscard]] BlockField field_of(const VolumeBlock& block) const {
    const auto from = [&](int axis) {
      return eye_.start[static_cast<std::size_t>(axis)] - static_cast<float>(block.origin[axis]);
    };
    BlockField field{{from(0), from(1), from(2)}, block.tsdf->buffer().data(), {}};
    const auto& mask = block.tsdf->getValueMask();
    for (openvdb::Index word = 0; word < 8; ++word) {
      const auto bits = mask.getWord<std::uint64_t>(word);
      std::memcpy(field.observed.data() + 2 * word, &bits, sizeof bits);
    }
    return field;
  }

  /// Blocks lie far apart, behind three pointers: the memory is asked for each some blocks ahead.
  void prefetch(std::span<const VisibleBlock> own, std::size_t i) const {
    const auto ahead = [&](std::size_t steps) -> const VolumeBlock* {
      return i + steps < own.size() ? &index_.blocks()[own[i + steps].number] : nullptr;
    };
    if (const VolumeBlock* block = ahead(6)) __builtin_prefetch(block);
    if (const VolumeBlock* block = ahead(4)) {
      const auto* leaf = reinterpret_cast<const char*>(block->tsdf);
      for (std::size_t byte = 0; byte < sizeof(TsdfLeaf); byte += kCacheLine) __builtin_prefetch(leaf + byte);
      __builtin_prefetch(block->colour);
    }
    if (const VolumeBlock* block = ahead(2)) {
      const float* values = block->tsdf->buffer().data();
      for (std::size_t value = 0; value < TsdfLeaf::SIZE; value += kCacheLine / sizeof(float)) {
        __builtin_prefetch(values + value);
      }
    }
  }

  void march(const VisibleBlock& visible) {
    const VolumeBlock& block = index_.blocks()[visible.number];
    voxels_.keep(block);
    const BlockField field = field_of(block);
    const int first = std::max(visible.pixels.x0 - pixels_.x0, 0) / kPixelGroup;
    const int last = std::min(visible.pixels.x1 - pixels_.x0, kTileWidth - 1) / kPixelGroup;
    const int to = std::min(visible.pixels.y1, pixels_.y1);
    for (int y = std::max(visible.pixels.y0, pixels_.y0); y <= to; ++y) {
      march_rays(field, eye_.voxel_size_m, &groups_[number_of(first, y)], last - first + 1);
    }
  }

  void show(const SeenGroup& seen, int x, int y, const Eigen::Matrix3f& R_camera_world, ModelView& view) const {
    const auto lane = static_cast<std::size_t>((x - pixels_.x0) % kPixelGroup);
    if (!(seen.depth_m[lane] > 0)) return;
    const Eigen::Vector3f gradient(seen.gradient[0][lane], seen.gradient[1][lane], seen.gradient[2][lane]);
    view.depth_m.at(x, y) = seen.depth_m[lane];
    view.normals.at(x, y) = (R_camera_world * gradient).normalized();
    view.intensity.at(x, y) = seen.intensity[lane];
  }

  const BlockIndex& index_;
  const Eye& eye_;
  PixelRect pixels_;
  VoxelReader voxels_;
  std::array<RayGroup, kGroups> groups_;
};

/// A picture in tiles, row by row, and the blocks that the rays of each pass, nearest first.
class Tiles {
 public:
  Tiles(const CameraIntrinsics& k, std::span<const VisibleBlock> blocks)
      : width_(k.width),
        height_(k.height),
        across_((k.width + kTileWidth - 1) / kTileWidth),
        blocks_(static_cast<std::size_t>(across_ * ((k.height + kTileRows - 1) / kTileRows))) {
    for (const VisibleBlock& block : blocks) {
      for (int y = block.pixels.y0 / kTileRows; y <= block.pixels.y1 / kTileRows; ++y) {
        for (int x = block.pixels.x0 / kTileWidth; x <= block.pixels.x1 / kTileWidth; ++x) {
          blocks_[static_cast<std::size_t>(y * across_ + x)].push_back(block);
        }
      }
    }
  }

  [[nodiscard]] std::size_t count() const { return blocks_.size(); }
  [[nodiscard]] std::span<const VisibleBlock> blocks(std::size_t tile) const { return blocks_[tile]; }
  [[nodiscard]] PixelRect pixels(std::size_t tile) const {
    const int x0 = static_cast<int>(tile) % across_ * kTileWidth;
    const int y0 = static_cast<int>(tile) / across_ * kTileRows;
    return {x0, y0, std::min(x0 + kTileWidth, width_) - 1, std::min(y0 + kTileRows, height_) - 1};
  }

 private:
  int width_, height_, across_;
  std::vector<std::vector<VisibleBlock>> blocks_;
};

}  // namespace

ModelView raycast(const TsdfVolume& volume, const CameraIntrinsics& k, const Pose& T_world_camera) {
  ModelView view{k, T_world_camera, DepthImage(k.width, k.height),
                 Image<Eigen::Vector3f>(k.width, k.height, Eigen::Vector3f::Zero()),
                 Image<float>(k.width, k.height, -1.0f)};
  const Eye eye(k, T_world_camera, volume.config().voxel_size_m);
  const Tiles tiles(k,
                    visible_blocks(volume.index(), k, T_world_camera, volume.config().voxel_size_m, kNearestSurface_m));
  const Eigen::Matrix3f R_camera_world = T_world_camera.linear().transpose().cast<float>();
  tbb::parallel_for(std::size_t{0}, tiles.count(), [&](std::size_t number) {
    if (tiles.blocks(number).empty()) return;
    Tile tile(volume.index(), eye, tiles.pixels(number));
    tile.march(tiles.blocks(number));
    tile.show(R_camera_world, view);
  });
  return view;
}

}  // namespace scanknit
