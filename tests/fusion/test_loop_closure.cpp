#include "fusion/loops/loop_closure.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <set>
#include <string>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::bare_wall;
using test::distance_m;
using test::look;
using test::motion;
using test::on_circle;
using test::small_room;

constexpr double kTolerance_m = 0.002;

/// Steps of the circle as a tracker with a bias has them.
struct Walk {
  KeyFrames frames{NoiseModel{}};
  std::vector<Pose> truth;

  explicit Walk(int steps, const Pose& bias = Pose::Identity()) {
    Pose T_world_camera = on_circle(0);
    for (int step = 0; step < steps; ++step) {
      if (step > 0) T_world_camera = T_world_camera * on_circle(step - 1).inverse() * on_circle(step) * bias;
      add(step, T_world_camera);
    }
  }
  void add(int step, const Pose& T_world_camera) {
    truth.push_back(on_circle(step));
    frames.add(look(small_room(), on_circle(step)), T_world_camera, false);
  }
};

double farthest(const std::vector<Pose>& found, const std::vector<Pose>& truth) {
  double most = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) most = std::max(most, distance_m(found[i], truth[i]));
  return most;
}

const Pose& small_bias() {
  static const Pose bias = motion({0.0008, -0.0006, 0.0006}, {0.0010, 0.0008, -0.0008});
  return bias;
}

TEST(LoopClosure, DistributesTheDriftOfAWalkThatComesBack) {
  const Walk walk(150, small_bias());
  // How far apart the walk has two frames, a round apart, that were taken at one place.
  const auto gap_m = [](const std::vector<Pose>& poses) { return distance_m(poses[10], poses[130]); };
  ASSERT_GT(gap_m(walk.frames.walk()), 0.03);
  const LoopClosure closure = close_loops(walk.frames, NoiseModel{}, kTolerance_m);
  EXPECT_TRUE(closure.is_corrected);
  EXPECT_GT(closure.drift_m, 0.03);
  EXPECT_LT(gap_m(closure.T_world_cameras), 0.05 * gap_m(walk.frames.walk()));
  EXPECT_LT(farthest(closure.T_world_cameras, walk.truth), farthest(walk.frames.walk(), walk.truth));
}

TEST(LoopClosure, LeavesAWalkThatDidNotDrift) {
  const Walk walk(150);
  const LoopClosure closure = close_loops(walk.frames, NoiseModel{}, kTolerance_m);
  EXPECT_TRUE(closure.has_loops());
  EXPECT_FALSE(closure.is_corrected);
  EXPECT_EQ(farthest(closure.T_world_cameras, walk.frames.walk()), 0);
}

TEST(LoopClosure, FindsNothingInAWalkAlongAWall) {
  KeyFrames frames(NoiseModel{});
  for (int step = 0; step < 40; ++step) {
    const Pose at = motion({0, 0, 0}, {0.1 * step, 0, 0});
    frames.add(look(bare_wall(), at), at, false);
  }
  const LoopClosure closure = close_loops(frames, NoiseModel{}, kTolerance_m);
  EXPECT_FALSE(closure.has_loops());
  EXPECT_FALSE(closure.is_corrected);
}

/// Away from the circle's first steps along a bare wall, `metres` far.
void walk_away(KeyFrames& frames, double metres) {
  for (int step = 1; step <= 10; ++step) {
    const Pose T_world_camera = motion({0, 0, 0}, {0.1 * metres * step, 0, 0}) * on_circle(5);
    frames.add(look(bare_wall(), T_world_camera), T_world_camera, false);
  }
}

std::set<std::string> refusals(const LoopClosure& closure) {
  std::set<std::string> reasons;
  for (const Loop& loop : closure.loops) reasons.insert(loop.refused);
  return reasons;
}

TEST(LoopClosure, APlaceThatOnlyLooksTheSameIsNoLoop) {
  Walk walk(6);
  walk_away(walk.frames, 6);
  const Pose T_twin = motion({0, 0, 0}, {6, 0, 0});
  for (int step = 0; step < 6; ++step)
    walk.frames.add(look(small_room(), on_circle(step)), T_twin * on_circle(step), false);
  const LoopClosure closure = close_loops(walk.frames, NoiseModel{}, kTolerance_m);
  EXPECT_FALSE(closure.is_corrected);
  EXPECT_EQ(refusals(closure), std::set<std::string>{"farther than the walk can have drifted"});
}

TEST(LoopClosure, OneLoopThatNoOtherAgreesWithIsNotBelieved) {
  Walk walk(6);
  walk_away(walk.frames, 2);
  walk.frames.add(look(small_room(), on_circle(3)), motion({0, 0, 0}, {0.06, 0, 0}) * on_circle(3), false);
  LoopClosure closure = close_loops(walk.frames, NoiseModel{}, kTolerance_m);
  ASSERT_TRUE(closure.has_loops());
  // Loops from one frame to several others agree with each other; a view of its own has none.
  EXPECT_EQ(closure.is_corrected, closure.loops.size() > 1);
}

TEST(LoopClosure, SaysWhereTheTrackerWasPulled) {
  Walk walk(0);
  const Pose pull = motion({0, 0.01, 0}, {0.05, 0, 0});
  for (int step = 0; step < 60; ++step) walk.add(step, step < 30 ? on_circle(step) : pull * on_circle(step));
  const LoopClosure closure = close_loops(walk.frames, NoiseModel{}, kTolerance_m);
  ASSERT_EQ(closure.mistracked.size(), 1u);
  EXPECT_LT(closure.mistracked[0].first, 30u);
  EXPECT_GE(closure.mistracked[0].last, 30u);

  std::vector<Pose> T_first_frames;
  const std::size_t first = closure.mistracked[0].first;
  for (std::size_t i = first; i <= closure.mistracked[0].last; ++i) {
    T_first_frames.push_back(walk.truth[first].inverse() * walk.truth[i]);
  }
  walk.frames.replace(first, T_first_frames);
  EXPECT_LT(farthest(walk.frames.walk(), walk.truth), 1e-9);
  EXPECT_TRUE(close_loops(walk.frames, NoiseModel{}, kTolerance_m).mistracked.empty());
}

TEST(LoopClosure, SameBitsForAnyNumberOfThreads) {
  const Walk walk(130, small_bias());
  const auto poses_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return close_loops(walk.frames, NoiseModel{}, kTolerance_m).T_world_cameras;
  };
  const auto one = poses_with(1);
  for (const std::size_t threads : {2u, 8u}) {
    const auto many = poses_with(threads);
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i].matrix(), many[i].matrix()) << i;
  }
}

TEST(KeyFrames, AreBoundedAndCoverTheWholeWalk) {
  KeyFrames frames(NoiseModel{}, 10);
  for (int step = 0; step < 120; ++step) {
    frames.add(look(small_room(), on_circle(step)), on_circle(step), false);
    ASSERT_LE(frames.kept().size(), 10u);
  }
  EXPECT_EQ(frames.kept().front().frame, 0u);
  EXPECT_GT(frames.kept().back().frame, 90u);
  EXPECT_GE(frames.kept().size(), 5u);
  EXPECT_NEAR(frames.kept().back().path.walked_m, 2 * test::kPi * static_cast<double>(frames.kept().back().frame) / 120,
              0.01);
}

TEST(KeyFrames, StandStillWithTheCamera) {
  KeyFrames frames(NoiseModel{});
  for (int i = 0; i < 5; ++i) frames.add(look(small_room(), on_circle(0)), on_circle(0), false);
  EXPECT_EQ(frames.kept().size(), 1u);
  EXPECT_EQ(frames.walk().size(), 5u);
}

}  // namespace
}  // namespace scanknit
