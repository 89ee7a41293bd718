#include "fusion/track/raycast.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/track/block_copies.h"
#include "fusion/track/march_rays.h"
#include "fusion/track/ray_surfaces.h"
#include "fusion/track/visible_blocks.h"
#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

/// The rays of a tile, one tile after the other.
class TileLooker {
 public:
  TileLooker(const TsdfVolume& volume, const Eye& eye, const Pose& T_world_camera)
      : index_(volume.index()),
        eye_(eye),
        R_camera_world_(T_world_camera.linear().transpose().cast<float>()),
        samples_(volume.index()) {}

  /// Fills in the pixels from (x0, y0); `blocks` are those that their rays pass, nearest first.
  void look(int x0, int y0, std::span<const VisibleBlock> blocks, ModelView& view) {
    samples_.clear();
    aim_rays(eye_, x0, y0, rays_);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      prefetch(blocks, i);
      if (rays_.is_open(blocks[i].pixels)) march(blocks[i]);
    }
    for (int down = 0; down < RayTile::kDown; ++down) {
      for (int across = 0; across < RayTile::kAcross; ++across) {
        SeenPatch seen;
        find_surfaces(eye_, R_camera_world_, rays_.patches[RayTile::number_of(across, down)], samples_, seen);
        show(seen, x0 + kPatchSide * across, y0 + kPatchSide * down, view);
      }
    }
  }

 private:
  /// Blocks lie far apart, behind three pointers: the memory is asked for each some blocks ahead.
  void prefetch(std::span<const VisibleBlock> blocks, std::size_t i) const {
    const auto ahead = [&](std::size_t steps) -> const VolumeBlock* {
      return i + steps < blocks.size() ? &index_.blocks()[blocks[i + steps].number] : nullptr;
    };
    if (const VolumeBlock* block = ahead(12)) __builtin_prefetch(block);
    if (const VolumeBlock* block = ahead(8)) {
      prefetch_all(block->tsdf, sizeof(TsdfLeaf));
      __builtin_prefetch(block->colour);
    }
    const VolumeBlock* block = ahead(4);
    if (block == nullptr || !rays_.is_open(blocks[i + 4].pixels)) return;
    prefetch_all(block->tsdf->buffer().data(), TsdfLeaf::SIZE * sizeof(float));
  }

  /// Into the second cache: the first one has too few places for what is on its way.
  static void prefetch_all(const void* memory, std::size_t bytes) {
    constexpr std::size_t kCacheLine = 64;
    for (std::size_t byte = 0; byte < bytes; byte += kCacheLine) {
      __builtin_prefetch(static_cast<const char*>(memory) + byte, 0, 2);
    }
  }

  void march(const VisibleBlock& visible) {
    const VolumeBlock& block = index_.blocks()[visible.number];
    const std::int32_t start = samples_.add_distances(visible.number);
    const auto from = [&](int axis) {
      return eye_.start[static_cast<std::size_t>(axis)] - static_cast<float>(block.origin[axis]);
    };
    const BlockField field{{from(0), from(1), from(2)}, samples_.distances().samples() + start};
    if (!march_rays(field, eye_.voxel_size_m, visible.pixels, rays_)) return;
    prefetch_all(colours_of(*block.colour), ColourLeaf::SIZE * sizeof(ColourCode));
  }

  static void show(const SeenPatch& seen, int x0, int y0, ModelView& view) {
    for (int y = y0; y < std::min(y0 + kPatchSide, view.intrinsics.height); ++y) {
      for (int x = x0; x < std::min(x0 + kPatchSide, view.intrinsics.width); ++x) {
        const auto lane = static_cast<std::size_t>((y - y0) * kPatchSide + x - x0);
        view.depth_m.at(x, y) = seen.depth_m[lane];
        view.normals.at(x, y) = {seen.normal[0][lane], seen.normal[1][lane], seen.normal[2][lane]};
        view.intensity.at(x, y) = seen.intensity[lane];
      }
    }
  }

  const BlockIndex& index_;
  const Eye& eye_;
  Eigen::Matrix3f R_camera_world_;
  TileSamples samples_;
  RayTile rays_;
};

/// A picture in tiles, row by row, and the blocks that the rays of each pass, nearest first.
class Tiles {
 public:
  Tiles(const CameraIntrinsics& k, std::span<const VisibleBlock> blocks)
      : across_((k.width + RayTile::kWidth - 1) / RayTile::kWidth),
        blocks_(static_cast<std::size_t>(across_ * ((k.height + RayTile::kHeight - 1) / RayTile::kHeight))) {
    for (const auto& [number, pixels] : blocks) {
      for (int y = pixels.y0 / RayTile::kHeight; y <= pixels.y1 / RayTile::kHeight; ++y) {
        for (int x = pixels.x0 / RayTile::kWidth; x <= pixels.x1 / RayTile::kWidth; ++x) {
          const int x0 = x * RayTile::kWidth, y0 = y * RayTile::kHeight;
          const PixelRect within{std::max(pixels.x0 - x0, 0), std::max(pixels.y0 - y0, 0),
                                 std::min(pixels.x1 - x0, RayTile::kWidth - 1),
                                 std::min(pixels.y1 - y0, RayTile::kHeight - 1)};
          blocks_[static_cast<std::size_t>(y * across_ + x)].push_back({number, within});
        }
      }
    }
  }

  [[nodiscard]] std::size_t count() const { return blocks_.size(); }
  /// With their pixels in the tile, counted from its first.
  [[nodiscard]] std::span<const VisibleBlock> blocks(std::size_t tile) const { return blocks_[tile]; }
  [[nodiscard]] int x0(std::size_t tile) const { return static_cast<int>(tile) % across_ * RayTile::kWidth; }
  [[nodiscard]] int y0(std::size_t tile) const { return static_cast<int>(tile) / across_ * RayTile::kHeight; }

 private:
  int across_;
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
  tbb::enumerable_thread_specific<TileLooker> lookers([&] { return TileLooker(volume, eye, T_world_camera); });
  tbb::parallel_for(std::size_t{0}, tiles.count(), [&](std::size_t number) {
    if (tiles.blocks(number).empty()) return;
    lookers.local().look(tiles.x0(number), tiles.y0(number), tiles.blocks(number), view);
  });
  return view;
}

}  // namespace scanknit
