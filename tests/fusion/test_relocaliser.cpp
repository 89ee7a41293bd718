#include "fusion/track/relocaliser.h"

#include <gtest/gtest.h>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::distance_m;
using test::look;
using test::motion;
using test::on_circle;
using test::small_room;

SurfacePyramid pyramid_at(const Pose& T_world_camera) {
  return pyramid_of(look(small_room(), T_world_camera), NoiseModel{});
}

TEST(Ferns, TellViewsFromEachOther) {
  const Ferns ferns(1.5);
  const auto code_at = [&](int step) { return ferns.encode(pyramid_at(on_circle(step)).levels.back()); };
  const FernCode here = code_at(0);
  EXPECT_EQ(dissimilarity(here, here), 0);
  EXPECT_LT(dissimilarity(here, code_at(1)), dissimilarity(here, code_at(5)));
  EXPECT_LT(dissimilarity(here, code_at(5)), dissimilarity(here, code_at(30)));
}

TEST(Ferns, OfAPictureWithoutDepthAreLikeNoOther) {
  const Ferns ferns(1.5);
  const FernCode blind = ferns.encode(pyramid_of(look(test::World(), Pose::Identity()), NoiseModel{}).levels.back());
  EXPECT_EQ(dissimilarity(blind, blind), 1);
}

TEST(Relocaliser, KeepsOneKeyFrameOfAViewThatStandsStill) {
  Relocaliser places;
  for (int i = 0; i < 5; ++i) places.learn(pyramid_at(on_circle(0)), on_circle(0));
  EXPECT_EQ(places.key_frames(), 1u);
  places.learn(pyramid_at(on_circle(30)), on_circle(30));
  EXPECT_EQ(places.key_frames(), 2u);
}

TEST(Relocaliser, NamesTheKeyFrameNearestToAView) {
  Relocaliser places;
  for (const int step : {0, 20, 40, 60, 80, 100}) places.learn(pyramid_at(on_circle(step)), on_circle(step));
  ASSERT_EQ(places.key_frames(), 6u);
  for (const int step : {0, 20, 40, 60, 80, 100}) {
    const auto poses = places.similar_poses(pyramid_at(on_circle(step + 2)));
    ASSERT_FALSE(poses.empty());
    EXPECT_EQ(poses.front().matrix(), on_circle(step).matrix()) << "step " << step;
  }
}

/// A wall of tiles, each of its own grey, from there: what features hold on to.
SurfacePyramid tiles_from(const Pose& T_world_camera) {
  const CameraIntrinsics camera{320, 240, 260, 260, 159.5, 119.5};
  const test::World wall = test::bare_wall();
  Frame frame = look(wall, T_world_camera, true, camera);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d p = T_world_camera * camera.unproject(x, y, static_cast<double>(frame.depth_m.at(x, y)));
      constexpr double kTile_m = 0.05;
      const auto column = static_cast<std::uint32_t>(static_cast<int>(std::floor(p.x() / kTile_m)) + 1000);
      const auto row = static_cast<std::uint32_t>(static_cast<int>(std::floor(p.y() / kTile_m)) + 1000);
      const std::uint32_t hash = (column * 73856093u) ^ (row * 19349663u);  // Teschner et al. 2003
      const auto grey = static_cast<std::uint8_t>((hash * 2654435761u) >> 24);
      frame.colour->image.at(x, y) = {grey, grey, grey};
    }
  }
  return pyramid_of(frame, NoiseModel{});
}

TEST(Features, GiveTheMotionBetweenTwoViews) {
  const Pose truth = motion({0.02, -0.05, 0.3}, {0.12, -0.06, 0.1});
  const SurfaceLevel from = tiles_from(Pose::Identity()).levels.front();
  const SurfaceLevel to = tiles_from(truth).levels.front();
  const auto found = match_features(find_features(from), find_features(to), to.intrinsics);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(distance_m(*found, truth), 0.05);  // half of what the coarse level of registration reaches
  EXPECT_LT(test::angle_rad(*found, truth), 0.05);
}

TEST(Features, OfOtherPlacesDoNotMatch) {
  const SurfaceLevel here = tiles_from(Pose::Identity()).levels.front();
  const SurfaceLevel elsewhere = tiles_from(motion({0, 0, 0}, {20, 0, 0})).levels.front();
  EXPECT_FALSE(match_features(find_features(here), find_features(elsewhere), here.intrinsics).has_value());
}

TEST(Features, NeedColour) {
  Frame frame = look(small_room(), on_circle(0), /*has_colour=*/false);
  EXPECT_TRUE(find_features(pyramid_of(frame, NoiseModel{}).levels.front()).empty());
}

TEST(Relocaliser, FindsAViewByTheFeaturesOfAKeyFrameFromNear) {
  Relocaliser places;
  constexpr double kStep_m = 0.04;
  const auto from = [](int step) { return motion({0, 0, 0}, {kStep_m * step, 0, 0}); };
  for (int step = 0; step < 9; ++step) places.learn(tiles_from(from(step)), from(step));
  ASSERT_EQ(places.key_frames(), 9u);
  EXPECT_GE(places.key_frames_with_features(), 2u);
  EXPECT_LE(places.key_frames_with_features(), 5u) << "half of them at most: finding features takes long";
  for (int step = 0; step < 9; ++step) {
    const auto poses = places.matched_poses(tiles_from(from(step)));
    ASSERT_FALSE(poses.empty()) << step;
    EXPECT_LT(distance_m(poses.front(), from(step)), 0.05) << step;
  }
}

TEST(Relocaliser, KnowsNoPlaceBeforeItHasLearntOne) {
  EXPECT_TRUE(Relocaliser().similar_poses(pyramid_at(on_circle(0))).empty());
  EXPECT_TRUE(Relocaliser().matched_poses(pyramid_at(on_circle(0))).empty());
}

}  // namespace
}  // namespace scanknit
