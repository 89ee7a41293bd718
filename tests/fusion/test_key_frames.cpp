#include "fusion/loops/key_frames.h"

#include <gtest/gtest.h>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::on_circle;

void add_steps(KeyFrames& frames, int first, int last) {
  for (int step = first; step != last; step += first < last ? 1 : -1) {
    frames.add(test::look(test::small_room(), on_circle(step)), on_circle(step), false);
  }
}

std::vector<Pose> circle(int first, int last) {
  std::vector<Pose> poses;
  for (int step = first; step < last; ++step) poses.push_back(on_circle(step));
  return poses;
}

/// Steps 10 to 19 were lost at first.
KeyFrames with_gap() {
  KeyFrames frames(NoiseModel{});
  add_steps(frames, 0, 10);
  frames.add(test::look(test::small_room(), on_circle(20)), on_circle(20), true);
  add_steps(frames, 21, 30);
  return frames;
}

void expect_whole_circle(const KeyFrames& frames) {
  ASSERT_EQ(frames.walk().size(), 30u);
  const double step_m = (on_circle(1).translation() - on_circle(0).translation()).norm();
  for (const KeyFrame& key : frames.kept()) {
    EXPECT_EQ(test::distance_m(key.T_world_camera, on_circle(static_cast<int>(key.frame))), 0);
    EXPECT_NEAR(key.path.walked_m, static_cast<double>(key.frame) * step_m, 1e-9);
    EXPECT_EQ(key.path.gaps, 0);
  }
  for (std::size_t i = 1; i < frames.kept().size(); ++i) {
    EXPECT_LT(frames.kept()[i - 1].frame, frames.kept()[i].frame);
  }
}

TEST(KeyFrames, InsertedFramesTakeTheirPlaceInTheWalk) {
  KeyFrames frames = with_gap();
  ASSERT_EQ(frames.kept().back().path.gaps, 1);
  KeyFrames found = frames.without_frames();
  add_steps(found, 10, 20);
  frames.insert(10, std::move(found), circle(10, 20), {});
  expect_whole_circle(frames);
}

TEST(KeyFrames, FramesThatCameBackwardsAreReversed) {
  KeyFrames frames = with_gap();
  KeyFrames found = frames.without_frames();
  add_steps(found, 19, 9);
  found.reverse();
  frames.insert(10, std::move(found), circle(10, 20), {});
  expect_whole_circle(frames);
}

TEST(KeyFrames, InsertedFramesKeepTheGapsBesideThem) {
  KeyFrames frames = with_gap();
  KeyFrames found = frames.without_frames();
  add_steps(found, 12, 18);
  frames.insert(10, std::move(found), circle(12, 18), {.before = true, .after = true});
  EXPECT_TRUE(frames.follows_gap(10));
  EXPECT_FALSE(frames.follows_gap(11));
  EXPECT_TRUE(frames.follows_gap(16));
  EXPECT_EQ(frames.kept().back().path.gaps, 2);
}

TEST(KeyFrames, TooManyAreThinnedOutAfterInsertingToo) {
  KeyFrames frames(NoiseModel{}, 4);
  add_steps(frames, 0, 10);
  KeyFrames found = frames.without_frames();
  add_steps(found, 10, 40);
  frames.insert(10, std::move(found), circle(10, 40), {});
  EXPECT_LE(frames.kept().size(), 4u);
  EXPECT_EQ(frames.walk().size(), 40u);
}

}  // namespace
}  // namespace scanknit
