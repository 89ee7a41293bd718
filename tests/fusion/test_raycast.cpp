#include "fusion/track/raycast.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "fusion/integrate/integrate.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::look;
using test::on_circle;
using test::small_camera;
using test::small_room;

constexpr double kRayVoxel = 0.02;

TsdfVolume fuse(const std::vector<Pose>& poses, bool has_colour = true) {
  FusionConfig config;
  config.voxel_size_m = kRayVoxel;
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  for (const Pose& pose : poses) EXPECT_TRUE(integrate(look(small_room(), pose, has_colour), pose, *volume));
  return std::move(volume).value();
}

std::size_t surfaces(const ModelView& view) {
  const auto depth = view.depth_m.pixels();
  return static_cast<std::size_t>(std::count_if(depth.begin(), depth.end(), [](float z) { return z > 0; }));
}

/// Shares of the pixels with a surface: those within a tenth of a voxel of the truth, measured across the surface, and
/// those whose normal is within 5 degrees.
struct Exactness {
  double depth, normals, intensity;
};
Exactness exactness(const ModelView& view) {
  const Frame truth = look(small_room(), view.T_world_camera, true, view.intrinsics);
  double right_depth = 0, right_normal = 0, right_intensity = 0;
  for (int y = 0; y < view.intrinsics.height; ++y) {
    for (int x = 0; x < view.intrinsics.width; ++x) {
      if (!(view.depth_m.at(x, y) > 0)) continue;
      const auto ray = view.intrinsics.unproject(x, y, 1.0).cast<float>();
      const float slope = truth.normals.at(x, y).dot(ray);
      const float off_m = std::abs(slope * (view.depth_m.at(x, y) - truth.depth_m.at(x, y)));
      right_depth += off_m < 0.1 * kRayVoxel ? 1 : 0;
      right_normal += view.normals.at(x, y).dot(truth.normals.at(x, y)) > std::cos(5 * test::kPi / 180) ? 1 : 0;
      const float grey = static_cast<float>(truth.colour->image.at(x, y).r) / 255.0f;
      right_intensity += std::abs(view.intensity.at(x, y) - grey) < 0.05f ? 1 : 0;
    }
  }
  const auto all = static_cast<double>(surfaces(view));
  return {right_depth / all, right_normal / all, right_intensity / all};
}

TEST(Raycast, SeesWhatWasFusedWhereItIs) {
  const ModelView view = raycast(fuse({on_circle(0), on_circle(2)}), small_camera(), on_circle(1));
  EXPECT_GT(surfaces(view), view.depth_m.size() * 9 / 10);
  const Exactness share = exactness(view);
  EXPECT_GT(share.depth, 0.95);  // the rest lies at the rims of the balls and in the corners of the room
  EXPECT_GT(share.normals, 0.9);
  EXPECT_GT(share.intensity, 0.95);
}

TEST(Raycast, SeesNothingInAnEmptyVolume) {
  const ModelView view = raycast(fuse({}), small_camera(), Pose::Identity());
  EXPECT_EQ(view.depth_m, DepthImage(160, 120));
  EXPECT_EQ(view.intensity, Image<float>(160, 120, -1.0f));
}

TEST(Raycast, SeesNoSurfaceFromBehind) {
  TsdfVolume volume = fuse({});
  ASSERT_TRUE(integrate(look(test::bare_wall(), Pose::Identity()), Pose::Identity(), volume));
  ASSERT_GT(surfaces(raycast(volume, small_camera(), Pose::Identity())), 10'000u);
  const Pose behind = test::motion({0, test::kPi, 0}, {0, 0, 2});
  EXPECT_EQ(surfaces(raycast(volume, small_camera(), behind)), 0u);
}

TEST(Raycast, HasNoIntensityWithoutColour) {
  const ModelView view = raycast(fuse({on_circle(0)}, /*has_colour=*/false), small_camera(), on_circle(0));
  ASSERT_GT(surfaces(view), 10'000u);
  EXPECT_EQ(view.intensity, Image<float>(160, 120, -1.0f));
}

TEST(Raycast, GivesTheSameBitsForAnyNumberOfThreads) {
  const TsdfVolume volume = fuse({on_circle(0), on_circle(3)});
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return raycast(volume, small_camera(), on_circle(1));
  };
  const ModelView one = with_threads(1);
  for (const std::size_t threads : {2u, 8u}) {
    const ModelView more = with_threads(threads);
    EXPECT_EQ(more.depth_m, one.depth_m);
    EXPECT_EQ(more.normals, one.normals);
    EXPECT_EQ(more.intensity, one.intensity);
  }
}

}  // namespace
}  // namespace scanknit
