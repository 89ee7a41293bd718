// The live mesh, chunk by chunk, is the mesh that extraction gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <numbers>
#include <vector>

#include "app/live/live_mesh.h"
#include "extract/extract_surface.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/block_index.h"
#include "tests/app/small_scan.h"

namespace scanknit {
namespace {

constexpr double kVoxel_m = 0.01;

FusionConfig fusion_config() {
  FusionConfig config;
  config.voxel_size_m = kVoxel_m;
  return config;
}

/// What the page keeps: the newest message of each chunk.
using Chunks = std::map<std::uint32_t, std::string>;

template <typename T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::size_t triangles_in(const Chunks& chunks) {
  std::size_t triangles = 0;
  for (const auto& [number, message] : chunks) {
    if (at<std::uint32_t>(message, 4) == 1) triangles += at<std::uint32_t>(message, 20) / 3;
  }
  return triangles;
}

/// Of all triangles in all chunks, sorted: their middles.
std::vector<std::array<float, 3>> middles(const Chunks& chunks) {
  std::vector<std::array<float, 3>> all;
  for (const auto& [number, message] : chunks) {
    if (at<std::uint32_t>(message, 4) != 1) continue;
    const auto vertices = at<std::uint32_t>(message, 16);
    const auto indices = at<std::uint32_t>(message, 20);
    for (std::uint32_t first = 0; first < indices; first += 3) {
      std::array<float, 3> sum{};
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        const auto vertex = at<std::uint16_t>(message, 48 + 16 * vertices + 2 * (first + corner));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto q = at<std::uint16_t>(message, 48 + 16 * vertex + 2 * axis);
          sum[axis] += (at<float>(message, 32 + 4 * axis) + at<float>(message, 44) * q) / 3;
        }
      }
      all.push_back(sum);
    }
  }
  return all;
}

class LiveMeshTest : public testing::Test {
 protected:
  void SetUp() override {
    auto created = TsdfVolume::create(fusion_config());
    ASSERT_TRUE(created);
    volume.emplace(*std::move(created));
    frames = test::small_scan("turntable", 8, 60, NoiseModel{});
    ASSERT_EQ(frames.size(), 8u);
  }

  void fuse(const Frame& frame) { ASSERT_TRUE(integrate(frame, *frame.T_world_camera, *volume)); }

  void update(LiveMesh& mesh, std::size_t most_leaves) {
    const auto updated = mesh.update(*volume, most_leaves, [&](std::uint32_t chunk, std::string message) {
      chunks[chunk] = std::move(message);
      ++published;
    });
    ASSERT_TRUE(updated) << updated.error().text();
  }

  std::optional<TsdfVolume> volume;
  std::vector<Frame> frames;
  Chunks chunks;
  std::size_t published = 0;
};

TEST_F(LiveMeshTest, EndsAsTheWholeMesh) {
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh) << mesh.error().text();
  for (const Frame& frame : frames) {
    fuse(frame);
    update(*mesh, 20);  // it lags behind
  }
  while (!mesh->is_up_to_date()) update(*mesh, 20);
  const auto whole = extract_surface(volume->field_view(), {});
  ASSERT_TRUE(whole);
  ASSERT_GT(whole->mesh.triangles.size(), 1'000u);
  EXPECT_EQ(mesh->triangles(), whole->mesh.triangles.size());
  EXPECT_EQ(triangles_in(chunks), whole->mesh.triangles.size());

  // Every triangle lies where extraction has one, but for the rounding to 16 bits of a chunk's extent.
  auto given = middles(chunks);
  std::vector<std::array<float, 3>> expected;
  for (const auto& [a, b, c] : whole->mesh.triangles) {
    const auto& p = whole->mesh.positions_m;
    const Eigen::Vector3f middle = (p[a] + p[b] + p[c]) / 3;
    expected.push_back({middle.x(), middle.y(), middle.z()});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto by_axis = [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; };
    std::sort(given.begin(), given.end(), by_axis);
    std::sort(expected.begin(), expected.end(), by_axis);
    constexpr auto kRounding = static_cast<float>(40 * kVoxel_m / 65535);
    for (std::size_t i = 0; i < given.size(); ++i) ASSERT_NEAR(given[i][axis], expected[i][axis], kRounding) << i;
  }
}

TEST_F(LiveMeshTest, NothingIsSentWhereNothingChanged) {
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh);
  fuse(frames.front());
  while (!mesh->is_up_to_date() || published == 0) update(*mesh, 100'000);
  published = 0;
  update(*mesh, 100'000);
  EXPECT_EQ(published, 0u);
}

TEST_F(LiveMeshTest, BeginsWithWhatTheVolumeHoldsAlready) {
  fuse(frames.front());
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh);
  (void)volume->take_changed_blocks();
  update(*mesh, 100'000);
  EXPECT_GT(triangles_in(chunks), 0u);
}

TEST_F(LiveMeshTest, KnowsWhetherABoxHoldsATriangle) {
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh);
  const Eigen::Vector3d far(100, 100, 100);
  EXPECT_FALSE(mesh->has_triangle_in({-far, far})) << "no mesh yet";
  fuse(frames.front());
  update(*mesh, 100'000);
  EXPECT_TRUE(mesh->has_triangle_in({-far, far}));
  EXPECT_FALSE(mesh->has_triangle_in({far, 2 * far}));
  const auto all = middles(chunks);
  ASSERT_FALSE(all.empty());
  const Eigen::Vector3d middle = Eigen::Vector3f(all[0][0], all[0][1], all[0][2]).cast<double>();
  const auto box_of = [&](double half_m) {
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(half_m);
    return Eigen::AlignedBox3d(middle - half, middle + half);
  };
  EXPECT_TRUE(mesh->has_triangle_in(box_of(2 * kVoxel_m)));
  EXPECT_FALSE(mesh->has_triangle_in(box_of(1e-6))) << "it cuts one, and holds none";
}

TEST_F(LiveMeshTest, AnAirLeafThatGetsMatterIsShownWithTheOthers) {
  // Walls across a camera that looks along -z: the leaf before a wall comes after the wall's own in every axis, so that
  // meshing the one does not mesh the other.
  const auto wall = [](double z_m) {
    Frame frame;
    frame.intrinsics = {160, 120, 131.25, 131.25, 79.5, 59.5};
    frame.depth_m = DepthImage(160, 120, static_cast<float>(-z_m));
    frame.T_world_camera = Pose(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()));
    EXPECT_TRUE(filter_frame(frame, AcquireConfig{}, NoiseModel{}));
    return frame;
  };
  constexpr double kBoundary_m = -12 * 8 * kVoxel_m;  // of two layers of leaves
  const auto with_matter = [&] {
    const auto& blocks = volume->index().blocks();
    return static_cast<std::size_t>(
        std::count_if(blocks.begin(), blocks.end(), [](const VolumeBlock& block) { return block.has_matter; }));
  };
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh);
  fuse(wall(kBoundary_m - 1.5 * kVoxel_m));
  const std::size_t behind = with_matter();
  ASSERT_LT(behind, volume->index().blocks().size()) << "the layer before it is air";
  update(*mesh, 0);  // all wait
  for (int i = 0; i < 5; ++i) fuse(wall(kBoundary_m + 2.5 * kVoxel_m));
  ASSERT_GT(with_matter(), behind) << "and is air no more";
  update(*mesh, behind);
  const auto shown = middles(chunks);
  const auto is_before = [&](const std::array<float, 3>& middle) { return middle[2] > kBoundary_m; };
  EXPECT_TRUE(std::any_of(shown.begin(), shown.end(), is_before)) << "the newest wait behind all others";
}

TEST_F(LiveMeshTest, WhatIsSeenOftenIsCovered) {
  auto mesh = LiveMesh::create(*volume, {});
  ASSERT_TRUE(mesh);
  const auto most_covered = [&] {
    int most = 0;
    for (const auto& [number, message] : chunks) {
      for (std::uint32_t i = 0; at<std::uint32_t>(message, 4) == 1 && i < at<std::uint32_t>(message, 16); ++i)
        most = std::max<int>(most, at<std::uint8_t>(message, 48 + 16 * i + 11));
    }
    return most;
  };
  fuse(frames.front());
  update(*mesh, 100'000);
  const int once = most_covered();
  for (int i = 0; i < 20; ++i) fuse(frames.front());
  update(*mesh, 100'000);
  EXPECT_GT(once, 0);
  EXPECT_LT(once, 200);
  EXPECT_EQ(most_covered(), 255);
}

TEST_F(LiveMeshTest, ADeciderWithoutAnIncrementalMesherIsShownByTheTrilinear) {
  ExtractConfig config;
  config.decider = Decider::kTetra6;
  EXPECT_TRUE(LiveMesh::create(*volume, config));
}

}  // namespace
}  // namespace scanknit
