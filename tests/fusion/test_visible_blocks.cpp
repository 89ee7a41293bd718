#include "fusion/track/visible_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "fusion/integrate/integrate.h"
#include "fusion/volume/block_index.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::look;
using test::on_circle;
using test::small_camera;
using test::small_room;

constexpr double kVoxel = 0.02;
constexpr float kNearest_m = 0.05f;

TsdfVolume room_volume() {
  FusionConfig config;
  config.voxel_size_m = kVoxel;
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  for (const int step : {0, 30, 60, 90}) {
    EXPECT_TRUE(integrate(look(small_room(), on_circle(step)), on_circle(step), *volume));
  }
  return std::move(volume).value();
}

openvdb::Coord block_round(const Eigen::Vector3d& p_world) {
  const auto along = [&](int axis) { return static_cast<int>(std::floor(p_world[axis] / kVoxel + 0.5)) & ~7; };
  return {along(0), along(1), along(2)};
}

TEST(VisibleBlocks, AreMetByEveryRayFrontToBackAndNoneIsMissed) {
  const TsdfVolume volume = room_volume();
  const Pose eye = on_circle(7);
  const CameraIntrinsics camera = small_camera();
  const auto visible = visible_blocks(volume.index(), camera, eye, kVoxel, kNearest_m);
  std::map<BlockIndex::Number, std::size_t> place;
  for (std::size_t i = 0; i < visible.size(); ++i) place[visible[i].number] = i;
  ASSERT_EQ(place.size(), visible.size()) << "a block twice";

  std::size_t met = 0;
  for (int y = 0; y < camera.height; y += 7) {
    for (int x = 0; x < camera.width; x += 7) {
      std::size_t last = 0;
      for (double z_m = kNearest_m; z_m < 4; z_m += 0.3 * kVoxel) {
        const BlockIndex::Number number = volume.index().find(block_round(eye * camera.unproject(x, y, z_m)));
        if (number == BlockIndex::kNone) continue;
        const VolumeBlock& block = volume.index().blocks()[number];
        if (!block.has_matter || block.is_free) continue;
        ASSERT_TRUE(place.count(number)) << block.origin;
        const VisibleBlock& seen = visible[place[number]];
        EXPECT_TRUE(x >= seen.pixels.x0 && x <= seen.pixels.x1 && y >= seen.pixels.y0 && y <= seen.pixels.y1);
        EXPECT_GE(place[number], last);
        last = place[number];
        ++met;
      }
    }
  }
  EXPECT_GT(met, 5000u);
}

TEST(VisibleBlocks, BehindTheCameraAreLeftOut) {
  const TsdfVolume volume = room_volume();
  const Pose eye = on_circle(0);
  for (const VisibleBlock& block : visible_blocks(volume.index(), small_camera(), eye, kVoxel, kNearest_m)) {
    const openvdb::Coord origin = volume.index().blocks()[block.number].origin;
    const Eigen::Vector3d centre = kVoxel * (Eigen::Vector3d(origin.x(), origin.y(), origin.z()).array() + 3.5);
    EXPECT_GT((eye.inverse() * centre).z(), -8 * kVoxel);
  }
}

/// Is all of the block on the other side of one of the planes through the eye that bound the picture?
bool is_beside_picture(const openvdb::Coord& origin, const Pose& eye, const CameraIntrinsics& camera) {
  std::array<int, 4> beyond{};
  for (int corner = 0; corner < 8; ++corner) {
    const auto along = [&](int axis) { return kVoxel * (origin[axis] - 0.5 + 8 * ((corner >> axis) & 1)); };
    const Eigen::Vector3d p = eye.inverse() * Eigen::Vector3d(along(0), along(1), along(2));
    const double u = camera.fx * p.x() + camera.cx * p.z(), v = camera.fy * p.y() + camera.cy * p.z();
    constexpr double kMargin = 2;  // pixels
    beyond[0] += u < -kMargin * p.z() ? 1 : 0;
    beyond[1] += u > (camera.width + kMargin) * p.z() ? 1 : 0;
    beyond[2] += v < -kMargin * p.z() ? 1 : 0;
    beyond[3] += v > (camera.height + kMargin) * p.z() ? 1 : 0;
  }
  return std::find(beyond.begin(), beyond.end(), 8) != beyond.end();
}

TEST(VisibleBlocks, BesideTheCameraAreLeftOut) {
  const TsdfVolume volume = room_volume();
  const Pose eye = on_circle(0);
  const CameraIntrinsics camera = small_camera();
  const auto reaches_across = [&](const VolumeBlock& block) {
    const Eigen::Vector3d centre =
        kVoxel * (Eigen::Vector3d(block.origin.x(), block.origin.y(), block.origin.z()).array() + 3.5);
    return std::abs((eye.inverse() * centre).z() - static_cast<double>(kNearest_m)) < 4 * kVoxel;
  };
  const auto blocks = volume.index().blocks();
  ASSERT_GT(std::count_if(blocks.begin(), blocks.end(),
                          [&](const VolumeBlock& b) {
                            return b.has_matter && reaches_across(b) && is_beside_picture(b.origin, eye, camera);
                          }),
            10);
  for (const VisibleBlock& block : visible_blocks(volume.index(), camera, eye, kVoxel, kNearest_m)) {
    EXPECT_FALSE(is_beside_picture(blocks[block.number].origin, eye, camera)) << blocks[block.number].origin;
  }
}

}  // namespace
}  // namespace scanknit
