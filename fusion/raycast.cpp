#include "fusion/raycast.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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

constexpr int kStripRows = 8;
constexpr std::size_t kCacheLine = 64;

/// Some rows of the picture.
class Strip {
 public:
  Strip(const BlockIndex& index, const Eye& eye, const CameraIntrinsics& k, int first_row)
      : index_(index),
        eye_(eye),
        width_(k.width),
        first_row_(first_row),
        rows_(std::min(kStripRows, k.height - first_row)),
        groups_across_((k.width + kPixelGroup - 1) / kPixelGroup),
        groups_(static_cast<std::size_t>(groups_across_ * rows_)) {
    for (int row = 0; row < rows_; ++row) {
      for (int across = 0; across < groups_across_; ++across) {
        aim_rays(eye, across * kPixelGroup, first_row + row, group(across, row));
      }
    }
  }

  void march(std::span<const VisibleBlock> blocks) {
    std::vector<VisibleBlock> own;
    for (const VisibleBlock& block : blocks) {
      if (block.pixels.y0 < first_row_ + rows_ && block.pixels.y1 >= first_row_) own.push_back(block);
    }
    for (std::size_t i = 0; i < own.size(); ++i) {
      prefetch(own, i);
      march(own[i]);
    }
  }

  void show(const Eigen::Matrix3f& R_camera_world, ModelView& view) {
    VoxelReader voxels(index_);
    std::vector<SeenGroup> seen(static_cast<std::size_t>(groups_across_));
    for (int row = 0; row < rows_; ++row) {
      const auto for_all = [&](auto look) {
        for (int across = 0; across < groups_across_; ++across) {
          look(group(across, row), seen[static_cast<std::size_t>(across)]);
        }
      };
      for_all([&](const RayGroup& rays, SeenGroup&) { prefetch_surfaces(eye_, rays, voxels); });
      for_all([&](RayGroup& rays, SeenGroup& found) { find_surfaces(eye_, rays, voxels, found); });
      for_all([&](const RayGroup& rays, SeenGroup& found) { prefetch_intensities(eye_, rays, voxels, found); });
      for_all([&](const RayGroup& rays, SeenGroup& found) { find_intensities(eye_, rays, voxels, found); });
      for (int x = 0; x < width_; ++x) show(seen, x, first_row_ + row, R_camera_world, view);
    }
  }

 private:
  [[nodiscard]] RayGroup& group(int across, int row) {
    return groups_[static_cast<std::size_t>(row * groups_across_ + across)];
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
    }
    if (const VolumeBlock* block = ahead(2)) {
      const float* values = block->tsdf->buffer().data();
      for (std::size_t value = 0; value < TsdfLeaf::SIZE; value += kCacheLine / sizeof(float)) {
        __builtin_prefetch(values + value);
      }
    }
  }

  void march(const VisibleBlock& block) {
    const BlockField field = field_of(index_.blocks()[block.number]);
    const int first = block.pixels.x0 / kPixelGroup;
    const int count = block.pixels.x1 / kPixelGroup - first + 1;
    const int from = std::max(block.pixels.y0 - first_row_, 0);
    const int to = std::min(block.pixels.y1 - first_row_, rows_ - 1);
    for (int row = from; row <= to; ++row) march_rays(field, eye_.voxel_size_m, &group(first, row), count);
  }

  static void show(std::span<const SeenGroup> row, int x, int y, const Eigen::Matrix3f& R_camera_world,
                   ModelView& view) {
    const SeenGroup& seen = row[static_cast<std::size_t>(x / kPixelGroup)];
    const auto lane = static_cast<std::size_t>(x % kPixelGroup);
    if (!(seen.depth_m[lane] > 0)) return;
    const Eigen::Vector3f gradient(seen.gradient[0][lane], seen.gradient[1][lane], seen.gradient[2][lane]);
    view.depth_m.at(x, y) = seen.depth_m[lane];
    view.normals.at(x, y) = (R_camera_world * gradient).normalized();
    view.intensity.at(x, y) = seen.intensity[lane];
  }

  const BlockIndex& index_;
  const Eye& eye_;
  int width_, first_row_, rows_, groups_across_;
  std::vector<RayGroup> groups_;
};

}  // namespace

ModelView raycast(const TsdfVolume& volume, const CameraIntrinsics& k, const Pose& T_world_camera) {
  ModelView view{k, T_world_camera, DepthImage(k.width, k.height),
                 Image<Eigen::Vector3f>(k.width, k.height, Eigen::Vector3f::Zero()),
                 Image<float>(k.width, k.height, -1.0f)};
  const Eye eye(k, T_world_camera, volume.config().voxel_size_m);
  const auto blocks =
      visible_blocks(volume.index(), k, T_world_camera, volume.config().voxel_size_m, kNearestSurface_m);
  const Eigen::Matrix3f R_camera_world = T_world_camera.linear().transpose().cast<float>();
  tbb::parallel_for(0, (k.height + kStripRows - 1) / kStripRows, [&](int number) {
    Strip strip(volume.index(), eye, k, kStripRows * number);
    strip.march(blocks);
    strip.show(R_camera_world, view);
  });
  return view;
}

}  // namespace scanknit
