#include "fusion/relocaliser.h"

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

TEST(Relocaliser, KnowsNoPlaceBeforeItHasLearntOne) {
  EXPECT_TRUE(Relocaliser().similar_poses(pyramid_at(on_circle(0))).empty());
  EXPECT_TRUE(Relocaliser().matched_poses(pyramid_at(on_circle(0))).empty());
}

}  // namespace
}  // namespace scanknit
