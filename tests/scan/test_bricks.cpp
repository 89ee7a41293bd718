// A volume that is fused in bricks gives the very mesh of a whole one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "extract/extract_surface.h"
#include "fusion/bricks/brick_parts.h"
#include "fusion/bricks/brick_plan.h"
#include "fusion/bricks/brick_volume.h"
#include "fusion/integrate/integrate.h"
#include "fusion/integrate/integrate_part.h"
#include "scan/bricks/layered_bricks.h"
#include "tests/core/temporary_folder.h"
#include "tests/fusion/small_world.h"

namespace scanknit::test {
namespace {

constexpr int kBrickFrames = 8;
constexpr CameraIntrinsics kBrickCamera{160, 120, 130, 130, 79.5, 59.5};

struct Seen {
  Frame frame;
  Pose pose;
};

std::vector<Seen> seen_frames() {
  const World world = World().add_wall({0, 0, 1}, 0).add_ball({0.1, 0, 0.06}, 0.08).add_ball({-0.06, 0, 0.06}, 0.08);
  std::vector<Seen> seen;
  for (int i = 0; i < kBrickFrames; ++i) {
    const double angle = 2 * kPi * i / kBrickFrames;
    const Pose pose = looking_at_origin({0.65 * std::cos(angle), 0.65 * std::sin(angle), i % 2 == 0 ? 0.4 : 0.6});
    seen.push_back({look(world, pose, /*has_colour=*/true, kBrickCamera), pose});
  }
  return seen;
}

FusionConfig brick_fusion() {
  FusionConfig config;
  config.voxel_size_m = 0.005;
  return config;
}

ExtractConfig brick_extract() {
  ExtractConfig config;
  config.min_component_triangles = 50;
  return config;
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same(const Mesh& a, const Mesh& b) {
  EXPECT_TRUE(same_bytes(a.positions_m, b.positions_m));
  EXPECT_TRUE(same_bytes(a.normals, b.normals));
  EXPECT_TRUE(same_bytes(a.colours, b.colours));
  EXPECT_TRUE(same_bytes(a.triangles, b.triangles));
}

BrickPlan plan_of(const std::vector<Seen>& seen) {
  BrickPlan plan(brick_fusion());
  for (const Seen& one : seen) EXPECT_TRUE(plan.add(one.frame, one.pose));
  return plan;
}

void fuse_part(const std::vector<Seen>& seen, const BrickPart& part, TsdfVolume& volume) {
  for (const FrameRun& run : part.frames) {
    for (std::uint32_t n = run.first; n <= run.last; ++n) {
      ASSERT_TRUE(integrate_part(seen[n - 1].frame, seen[n - 1].pose, n, part.regions, volume));
    }
  }
}

class Bricks : public ::testing::TestWithParam<int> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(Bricks, GiveTheMeshOfTheWholeVolume) {
  const std::vector<Seen> seen = seen_frames();
  auto whole = TsdfVolume::create(brick_fusion());
  ASSERT_TRUE(whole);
  for (const Seen& one : seen) ASSERT_TRUE(integrate(one.frame, one.pose, *whole));
  const auto expected = extract_surface(whole->field_view(), brick_extract());
  ASSERT_TRUE(expected);
  ASSERT_GT(expected->mesh.triangles.size(), 1000u);

  auto parts = parts_of_bricks(plan_of(seen), GetParam(), std::size_t{1} << 30);
  ASSERT_TRUE(parts) << parts.error().text();
  std::reverse(parts->begin(), parts->end());
  BrickVolume bricks(brick_fusion());
  std::size_t blocks = 0;
  for (std::size_t i = 0; i < parts->size(); ++i) {
    auto volume = TsdfVolume::create(brick_fusion());
    ASSERT_TRUE(volume);
    ASSERT_NO_FATAL_FAILURE(fuse_part(seen, (*parts)[i], *volume));
    blocks += volume->blocks();
    const auto path = folder_ / (std::to_string(i) + ".brick");
    ASSERT_TRUE(write_brick_file(*volume, 7, path));
    ASSERT_TRUE(bricks.add(path, 7));
  }
  EXPECT_EQ(blocks, whole->blocks());
  LayeredBricks layers(bricks);
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{300}, std::size_t{1} << 20}) {
    const auto joined = extract_surface(layers, brick_extract(), at_once);
    ASSERT_TRUE(joined) << joined.error().text();
    expect_same(joined->mesh, expected->mesh);
  }
}

INSTANTIATE_TEST_SUITE_P(Voxels, Bricks, ::testing::Values(64, 128, 256), ::testing::PrintToStringParamName());

TEST(BrickFiles, ThatAreDamagedAreRefused) {
  const std::vector<Seen> seen = seen_frames();
  const auto parts = parts_within(plan_of(seen), std::size_t{1} << 30);
  ASSERT_EQ(parts.size(), 1u);
  auto volume = TsdfVolume::create(brick_fusion());
  ASSERT_TRUE(volume);
  ASSERT_NO_FATAL_FAILURE(fuse_part(seen, parts.front(), *volume));
  TemporaryFolder folder;
  const auto path = folder / "a.brick";
  ASSERT_TRUE(write_brick_file(*volume, 7, path));
  EXPECT_FALSE(BrickFile::open(path, 8));
  const auto size = std::filesystem::file_size(path);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(1000);
    file.put('\x5a').put('\x17').put('\x2b');
  }
  const auto damaged = BrickFile::open(path, 7);
  ASSERT_TRUE(damaged);
  auto read = TsdfVolume::create(brick_fusion());
  ASSERT_TRUE(read);
  EXPECT_FALSE(damaged->read(damaged->layers().front(), *read));
  for (const std::uintmax_t cut : {size - 1, size - 30, size / 2, std::uintmax_t{9}, std::uintmax_t{0}}) {
    std::filesystem::resize_file(path, cut);
    EXPECT_FALSE(BrickFile::open(path, 7)) << cut;
  }
}

}  // namespace
}  // namespace scanknit::test
