#include <gtest/gtest.h>

#include "fusion/integrate/integrate.h"
#include "fusion/track/still_camera.h"
#include "fusion/track/tracker.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::bare_wall;
using test::look;
using test::motion;
using test::small_room;
using test::World;

const NoiseModel kStillNoise;

SurfaceLevel level_of(const Frame& frame) {
  return pyramid_of(frame, kStillNoise).levels.front();
}

/// Somebody before a wall who fills a third of the picture, `step` cm farther to the right.
World somebody(int step) {
  return bare_wall().add_ball({-0.2 + 0.01 * step, 0.1, 0.75}, 0.25);
}

FusionConfig coarse() {
  FusionConfig config;
  config.voxel_size_m = 0.02;
  return config;
}

/// As many pixels as tracking uses of a Kinect's picture, with a pattern of some five centimetres.
Frame see(const World& world, const Pose& T_world_camera) {
  Frame frame = look(world, T_world_camera, /*has_colour=*/true, {320, 240, 260, 260, 159.5, 119.5});
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      const double z_m = frame.depth_m.at(x, y);
      const Eigen::Vector3d p = 120 * (T_world_camera * frame.intrinsics.unproject(x, y, z_m));
      const double grey = 128 + 60 * std::sin(p.x() + 0.3 * p.y()) + 40 * std::sin(0.8 * p.y() - 0.5 * p.z());
      const auto level = static_cast<std::uint8_t>(std::lround(grey));
      frame.colour->image.at(x, y) = {level, level, level};
    }
  }
  return frame;
}

Frame brighter(Frame frame) {
  for (Rgb8& pixel : frame.colour->image.pixels())
    pixel.r = pixel.g = pixel.b = static_cast<std::uint8_t>(pixel.r / 2 + 40);
  return frame;
}

TEST(StandsStill, OnlyWhereNothingHasMovedInMostOfThePicture) {
  const SurfaceLevel before = level_of(see(small_room(), test::on_circle(0)));
  EXPECT_TRUE(stands_still(before, before, kStillNoise));
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d way = Eigen::Vector3d::Unit(axis);
    const Pose turned = test::on_circle(0) * motion(0.002 * way, {0, 0, 0});
    const Pose shifted = test::on_circle(0) * motion({0, 0, 0}, 0.003 * way);
    EXPECT_FALSE(stands_still(level_of(see(small_room(), turned)), before, kStillNoise)) << "axis " << axis;
    EXPECT_FALSE(stands_still(level_of(see(small_room(), shifted)), before, kStillNoise)) << "axis " << axis;
  }
}

TEST(StandsStill, WhoeverMovesAndHoweverBrightnessChanges) {
  const SurfaceLevel before = level_of(see(somebody(0), Pose::Identity()));
  for (const int step : {1, 5, 20}) {
    EXPECT_TRUE(stands_still(level_of(see(somebody(step), Pose::Identity())), before, kStillNoise)) << step;
    EXPECT_TRUE(stands_still(level_of(brighter(see(somebody(step), Pose::Identity()))), before, kStillNoise)) << step;
    const Pose along = motion({0, 0, 0}, {0.003, 0, 0});
    EXPECT_FALSE(stands_still(level_of(see(somebody(step), along)), before, kStillNoise)) << step;
  }
}

TEST(StandsStill, CannotBeToldWithoutPatterns) {
  const SurfaceLevel before = level_of(look(bare_wall(), Pose::Identity(), /*has_colour=*/false));
  EXPECT_FALSE(stands_still(before, before, kStillNoise));
}

TEST(Tracker, StandsStillWhileSomebodyMovesBeforeAWall) {
  auto volume = TsdfVolume::create(coarse());
  ASSERT_TRUE(volume);
  Tracker tracker;
  for (int step = 0; step < 30; ++step) {
    Frame frame = see(somebody(step), Pose::Identity());
    frame.timestamp_ns = step + 1;
    const TrackResult result = tracker.track(frame, *volume);
    ASSERT_FALSE(result.is_lost()) << "frame " << step << ": " << to_string(result.reason);
    ASSERT_EQ(result.T_world_camera.matrix(), Pose::Identity().matrix()) << "frame " << step;
    ASSERT_TRUE(integrate(frame, result.T_world_camera, *volume));
  }
}

TEST(Tracker, KnowsItsPlaceAgainWhenTheCameraStoodStillBehindACover) {
  auto volume = TsdfVolume::create(coarse());
  ASSERT_TRUE(volume);
  Tracker tracker;
  const Frame open = see(small_room(), test::on_circle(0));
  const Frame covered = see(World(), Pose::Identity());
  ASSERT_FALSE(tracker.track(open, *volume).is_lost());
  ASSERT_TRUE(integrate(open, Pose::Identity(), *volume));
  for (int frame = 0; frame < 20; ++frame) EXPECT_TRUE(tracker.track(covered, *volume).is_lost());
  EXPECT_EQ(tracker.track(open, *volume).state, TrackState::kRecovered);
}

}  // namespace
}  // namespace scanknit
