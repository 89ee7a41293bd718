// The axis and the angles of a turntable, from poses and from pairs of frames.
#include <gtest/gtest.h>

#include <cmath>

#include "core/counter_random.h"
#include "core/rotation.h"
#include "fusion/turntable/look_through.h"
#include "fusion/turntable/still_scene.h"
#include "fusion/turntable/turntable_prior.h"
#include "fusion/turntable/turntable_solver.h"
#include "fusion/turntable/turntable_space.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using test::kPi;

// One pair of frames is so far off, one standard deviation along each axis; half a circle of them leaves about twice
// that.
constexpr double kPair_m = 2e-4;
constexpr double kPair_rad = 1e-3;
constexpr double kMostOff_rad = 4 * kPair_rad;  // 0.23 degrees

TurntableAxis tilted_axis() {
  return {Vector3d(0.06, 0.88, 0.47).normalized(), Vector3d(-0.02, 0.01, 0.65)};
}

double line_distance(const TurntableAxis& axis, const Vector3d& p) {
  return (p - axis.point).cross(axis.direction).norm();
}

Pose small_error(std::uint64_t number, double size_m, double size_rad) {
  CounterRandom random(7, 0, number);
  const auto vector = [&](double size) -> Vector3d {
    return size * Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
  };
  const Vector3d turn = vector(size_rad);
  return test::motion(turn, vector(size_m));
}

/// A turn and a bit in unsteady steps of about 10 degrees, with every pair up to three steps apart, and all round the
/// circle as well.
struct Turn {
  TurntableMotion truth;
  std::vector<TurntableEdge> edges;
};
Turn noisy_turn(bool has_loops = true) {
  Turn turn;
  turn.truth.axis = tilted_axis();
  constexpr int kFrames = 40;
  for (int i = 0; i < kFrames; ++i) {
    CounterRandom random(3, 0, static_cast<std::uint64_t>(i));
    turn.truth.angles_rad.push_back(i == 0 ? 0 : (10.0 * i + 0.5 * random.gaussian()) * kDegree);
  }
  for (std::size_t i = 0; i < kFrames; ++i) {
    for (std::size_t j = i + 1; j < kFrames; ++j) {
      const double apart = turn.truth.angles_rad[j] - turn.truth.angles_rad[i];
      if (std::abs(has_loops ? std::remainder(apart, 2 * kPi) : apart) > 35 * kDegree) continue;
      TurntableEdge edge{i, j, turn_about(turn.truth.axis, apart)};
      edge.centre = Vector3d(0, 0, 0.65);
      edge.T_from_to = edge.T_from_to * small_error(1000 * i + j, kPair_m, kPair_rad);
      edge.information.diagonal() << 2.5e7, 2.5e7, 2.5e7, 1e6, 1e6, 1e6;
      turn.edges.push_back(edge);
    }
  }
  return turn;
}

double worst_angle(const TurntableMotion& found, const TurntableMotion& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.angles_rad.size(); ++i) {
    worst = std::max(worst, std::abs(found.angles_rad[i] - truth.angles_rad[i]));
  }
  return worst;
}

/// The truth, badly known: as tracking that lost a twentieth of the turn would have it.
TurntableMotion drifted(const TurntableMotion& truth) {
  TurntableMotion motion = truth;
  motion.axis.direction = (truth.axis.direction + Vector3d(0.05, 0, -0.04)).normalized();
  motion.axis.point += Vector3d(0.01, 0, 0.01);
  for (double& angle : motion.angles_rad) angle *= 0.95;
  return motion;
}

TEST(TurntableAxis, IsFoundFromPosesAlone) {
  const TurntableAxis axis = tilted_axis();
  const Pose T_world_first = test::motion({0.3, -0.2, 0.5}, {1, 2, 3});
  std::vector<Pose> poses;
  for (int i = 0; i < 60; ++i) {
    poses.push_back(T_world_first * turn_about(axis, -7 * kDegree * i) *
                    small_error(static_cast<std::uint64_t>(i), 3e-4, 1e-3));
  }
  const auto motion = fit_turntable(poses, 0.65);
  ASSERT_TRUE(motion);
  EXPECT_GT(std::abs(motion->axis.direction.dot(axis.direction)), std::cos(0.1 * kDegree));
  EXPECT_LT(line_distance(axis, motion->axis.point), 5e-4);
  EXPECT_NEAR(motion->angles_rad.back(), 59 * 7 * kDegree, 0.3 * kDegree);  // more than a turn, and growing
  const std::vector<double> off = distances_from(*motion, poses, 0.65);
  EXPECT_LT(*std::max_element(off.begin(), off.end()), 4e-3);  // three deviations of a turn at 0.65 m, and of a shift
}

TEST(TurntableAxis, OfPosesThatHardlyTurnIsUnknown) {
  std::vector<Pose> poses;
  for (int i = 0; i < 60; ++i) poses.push_back(test::motion({0, 0.1 * kDegree * i, 0}, {0.01 * i, 0, 0}));
  EXPECT_FALSE(fit_turntable(poses, 0.65));
}

TEST(TurntableSolver, FindsAxisAndAnglesFromNoisyPairs) {
  const Turn turn = noisy_turn();
  const TurntableSolution found = solve_turntable(drifted(turn.truth), turn.edges, std::nullopt);
  EXPECT_GT(found.motion.axis.direction.dot(turn.truth.axis.direction), std::cos(0.03 * kDegree));
  EXPECT_LT(line_distance(turn.truth.axis, found.motion.axis.point), kPair_m);
  EXPECT_LT(worst_angle(found.motion, turn.truth), kMostOff_rad);
  EXPECT_EQ(found.motion.angles_rad.front(), 0);
}

TEST(TurntableSolver, ATurnThatClosesHasNoDrift) {
  const Turn open = noisy_turn(false);
  const Turn closed = noisy_turn(true);
  const auto last_error = [](const Turn& turn) {
    const TurntableSolution found = solve_turntable(turn.truth, turn.edges, std::nullopt);
    return std::abs(found.motion.angles_rad.back() - turn.truth.angles_rad.back());
  };
  EXPECT_LT(last_error(closed), last_error(open));
  EXPECT_LT(last_error(closed), 0.05 * kDegree);
}

TEST(TurntableSolver, PairsThatAreWrongLoseTheirSay) {
  Turn turn = noisy_turn();
  for (std::size_t i = 0; i < turn.edges.size(); i += 8) {
    turn.edges[i].T_from_to = turn.edges[i].T_from_to * test::motion({0, 9 * kDegree, 0}, {0.02, 0, 0});
  }
  const TurntableSolution found = solve_turntable(turn.truth, turn.edges, std::nullopt);
  EXPECT_LT(worst_angle(found.motion, turn.truth), kMostOff_rad);
  for (std::size_t i = 0; i < turn.edges.size(); ++i) {
    const bool is_wrong = i % 8 == 0;
    EXPECT_LT(found.weights[i], is_wrong ? 0.1 : 1.1);
    EXPECT_GT(found.weights[i], is_wrong ? -1 : 0.3);
  }
}

TEST(TurntableSolver, WhatTheSceneDoesNotHoldIsThePriors) {
  Turn turn = noisy_turn();
  // Nothing along the twist about the axis: an object that looks alike from all sides.
  for (TurntableEdge& edge : turn.edges) {
    Vector6d twist;
    const Vector3d& a = turn.truth.axis.direction;
    twist << a.cross(edge.centre - turn.truth.axis.point), a;
    const Matrix6d across = Matrix6d::Identity() - twist * twist.transpose() / twist.squaredNorm();
    edge.information = across * edge.information * across;
  }
  AnglePrior prior;
  for (const double angle : turn.truth.angles_rad) prior.angles_rad.push_back(angle + 1.2);  // any offset
  prior.sigma_rad = 0.5 * kDegree;
  TurntableMotion start = turn.truth;
  for (std::size_t i = 1; i < start.angles_rad.size(); ++i) start.angles_rad[i] += 3 * kDegree;
  const TurntableSolution found = solve_turntable(start, turn.edges, prior);
  EXPECT_LT(worst_angle(found.motion, turn.truth), 0.3 * kDegree);
  EXPECT_GT(found.angle_sigma_rad, 0.5 * kDegree);  // it says so
  EXPECT_LT(solve_turntable(start, noisy_turn().edges, prior).angle_sigma_rad, 3 * kPair_rad);
}

TEST(TurntableAngles, OfLostFramesGoOnByTheUsualStep) {
  const std::vector<std::uint64_t> sequences = {0, 1, 2, 3, 4, 5, 6, 7};
  const auto between = angles_of_all(sequences, {1, 2, 4, 6}, {10, 20, 40, 60});
  for (std::size_t i = 0; i < sequences.size(); ++i) EXPECT_NEAR(between[i], 10.0 * static_cast<double>(i), 1e-9);
  const auto jump = angles_of_all(sequences, {0, 1, 2, 3, 6, 7}, {0, 10, 20, 30, -100, -90});
  EXPECT_NEAR(jump[4], 40, 1e-9);
  EXPECT_NEAR(jump[5], 50, 1e-9);
  EXPECT_NEAR(jump[6], -100, 1e-9);
}

TEST(TurntableAngles, FollowPairsWhereTrackingWasWrong) {
  const Turn turn = noisy_turn();
  TurntableMotion wrong = turn.truth;
  wrong.angles_rad[9] -= 100 * kDegree;
  for (std::size_t i = 20; i < wrong.angles_rad.size(); ++i) wrong.angles_rad[i] += 60 * kDegree;
  const TurntableMotion along = along_pairs(wrong, turn.edges);
  for (std::size_t i = 0; i < wrong.angles_rad.size(); ++i) {
    EXPECT_NEAR(along.angles_rad[i], turn.truth.angles_rad[i], 3 * kDegree) << i;
  }
}

TEST(TurntablePrior, OfAnotherScaleIsContradicted) {
  const TurntableMotion seen = noisy_turn().truth;
  const std::vector<std::size_t> whole(seen.angles_rad.size(), 0);
  std::vector<double> known;
  for (std::size_t i = 0; i < whole.size(); ++i) known.push_back((9.3 * static_cast<double>(i) + 20) * kDegree);
  const PriorCheck off = check_prior(known, seen, whole, 2 * kDegree);
  EXPECT_TRUE(off.contradicts);
  EXPECT_NEAR(off.scale, 10 / 9.3, 0.01);
  EXPECT_GT(off.typical_off_rad, 4 * kDegree);
  for (double& angle : known) angle = (angle - 20 * kDegree) * 10 / 9.3;
  const PriorCheck right = check_prior(known, seen, whole, 2 * kDegree);
  EXPECT_FALSE(right.contradicts);
  EXPECT_TRUE(right.off.empty());
}

TEST(TurntablePrior, OneMistypedAngleIsThatOfThePictures) {
  const TurntableMotion seen = noisy_turn().truth;
  const std::vector<std::size_t> whole(seen.angles_rad.size(), 0);
  std::vector<double> known = seen.angles_rad;
  known[7] = 7000 * kDegree;
  known[20] += 2 * kPi;  // the same place
  const PriorCheck check = check_prior(known, seen, whole, 2 * kDegree);
  EXPECT_FALSE(check.contradicts);
  EXPECT_EQ(check.off, std::vector<std::size_t>{7});
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_NEAR(check.agreed_angles_rad[i], seen.angles_rad[i], 1e-9);
}

TEST(TurntablePrior, SaysWhereAPartIsThatNoPairHolds) {
  Turn turn = noisy_turn(false);
  std::erase_if(turn.edges, [](const TurntableEdge& edge) { return edge.from < 12 && edge.to >= 12; });
  TurntableSolution solution = solve_turntable(turn.truth, turn.edges, std::nullopt);
  const std::vector<std::size_t> parts = turntable_parts(solution, turn.edges, 0.3);
  for (std::size_t i = 0; i < parts.size(); ++i) EXPECT_EQ(parts[i], i < 12 ? 1u : 0u) << i;
  std::vector<double> known = turn.truth.angles_rad;  // the pictures do not know how the parts lie to each other
  TurntableMotion shifted = turn.truth;
  for (std::size_t i = 12; i < parts.size(); ++i) shifted.angles_rad[i] -= 90 * kDegree;
  EXPECT_TRUE(check_prior(known, shifted, parts, 2 * kDegree).off.empty());
}

TEST(TurntablePrior, PairsOfAJumpBackwardsBesideALostFrameAreNotBelieved) {
  Turn turn = noisy_turn(false);
  for (std::size_t i = 12; i < turn.truth.angles_rad.size(); ++i) turn.truth.angles_rad[i] -= 20 * kDegree;
  std::vector<bool> is_tracked(turn.truth.angles_rad.size(), true);
  for (const bool jump : backward_jumps(turn.truth, turn.edges, is_tracked)) EXPECT_FALSE(jump);
  for (std::size_t i = 12; i < is_tracked.size(); ++i) is_tracked[i] = false;
  const std::vector<bool> jumps = backward_jumps(turn.truth, turn.edges, is_tracked);
  for (std::size_t i = 0; i < jumps.size(); ++i) {
    EXPECT_EQ(jumps[i], turn.edges[i].from < 12 && turn.edges[i].to >= 12) << i;
  }
}

NoiseModel noise() {
  return {};
}

/// A wall at 0.9 m with a block at 0.6 m that moves along, and a thing at 0.5 m in the two of them in between.
std::vector<DepthImage> passing_block(bool has_visitor) {
  std::vector<DepthImage> pictures;
  for (int i = 0; i < 20; ++i) {
    DepthImage picture(64, 32, 0.9f);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        CounterRandom random(1, static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(64 * y + x));
        if (y >= 8 && y < 24 && x >= 10 + i && x < 26 + i) picture.at(x, y) = 0.6f;
        if (has_visitor && (i == 9 || i == 10) && x >= 50) picture.at(x, y) = 0.5f;
        picture.at(x, y) += static_cast<float>(noise().sigma_m(0.9) * random.gaussian());
        if (random.uniform() < 0.1) picture.at(x, y) = 0;
      }
    }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

std::size_t readings(const DepthImage& picture, int x0, int x1) {
  std::size_t count = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = x0; x < x1; ++x) count += picture.at(x, y) > 0;
  }
  return count;
}

TEST(StillScene, IsTakenOutAndWhatMovesIsLeft) {
  const std::vector<DepthImage> pictures = passing_block(false);
  const StillScene still = StillScene::learn(pictures, noise());
  ASSERT_FALSE(still.empty());
  for (int i : {5, 10, 14}) {
    DepthImage picture = pictures[static_cast<std::size_t>(i)];
    still.remove_from(picture);
    EXPECT_EQ(readings(picture, 0, 10 + i), 0u) << i;
    EXPECT_EQ(readings(picture, 26 + i, 64), 0u) << i;
    EXPECT_GT(readings(picture, 12 + i, 24 + i), 150u) << i;  // of 192, a tenth of them holes
  }
}

TEST(StillScene, WhatComesByRarelyIsTakenOutToo) {
  const std::vector<DepthImage> pictures = passing_block(true);
  DepthImage picture = pictures[9];
  StillScene::learn(pictures, noise()).remove_from(picture);
  EXPECT_EQ(readings(picture, 50, 64), 0u);
  EXPECT_GT(readings(picture, 21, 33), 150u);
}

TEST(StillScene, OfACameraThatMovesIsEmpty) {
  std::vector<DepthImage> pictures;
  for (int i = 0; i < 20; ++i) pictures.emplace_back(64, 32, 0.6f + 0.02f * static_cast<float>(i));
  const StillScene still = StillScene::learn(pictures, noise());
  EXPECT_TRUE(still.empty());
  DepthImage picture = pictures[3];
  still.remove_from(picture);
  EXPECT_EQ(picture, pictures[3]);
}

TEST(TurntableSpace, IsTheRoomOfWhatMovesAboveTheDisc) {
  // The camera looks along z at a ball of 5 cm radius, 2 cm off an upright axis at 0.6 m, from 30 degrees above.
  const CameraIntrinsics camera = test::small_camera();
  const Vector3d up(0, -std::cos(30 * kDegree), -std::sin(30 * kDegree));
  const TurntableAxis axis{up, {0, 0, 0.6}};
  const double disc_m = -0.05;
  std::vector<DepthImage> samples;
  DepthImage floor(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = camera.unproject(x, y, 1.0);
      floor.at(x, y) = static_cast<float>((disc_m + up.dot(axis.point)) / up.dot(ray));
    }
  }
  const auto side = up.unitOrthogonal();
  for (int i = 0; i < 48; ++i) {
    const Vector3d centre = turn_about(axis, 7.5 * kDegree * i) * Vector3d(axis.point + 0.02 * side);
    DepthImage picture = floor;
    const Frame ball = test::sphere_frame(camera, centre, 0.05);
    for (std::size_t k = 0; k < picture.size(); ++k) {
      const float z = ball.depth_m.pixels()[k];
      if (z > 0) picture.pixels()[k] = std::min(picture.pixels()[k], z);
    }
    samples.push_back(picture);
  }
  const StillScene still = StillScene::learn(samples, noise());
  std::vector<DepthImage> moving = samples;
  for (DepthImage& picture : moving) still.remove_from(picture);
  const auto space = find_space(moving, still, camera, axis);
  ASSERT_TRUE(space);
  EXPECT_GT(space->up.dot(up), 0.999);
  EXPECT_GT(space->radius_m, 0.07);
  EXPECT_LT(space->radius_m, 0.10);
  ASSERT_TRUE(space->disc_m);
  EXPECT_NEAR(*space->disc_m, disc_m, 1e-3);
  DepthImage cut = samples[0];
  cut_to_space(cut, camera, *space, -0.01);
  const std::size_t ball = readings(moving[0], 0, camera.width);
  EXPECT_GT(readings(cut, 0, camera.width), ball * 7 / 10);
  EXPECT_LT(readings(cut, 0, camera.width), ball * 13 / 10);
}

TEST(LookThrough, TakesOutWhatOthersLookThrough) {
  // A wall that turns with the table's axis upright behind it would be no surprise; a ball that one frame sees is.
  const CameraIntrinsics camera = test::small_camera();
  const TurntableAxis axis{{0, -1, 0}, {0, 0, 0.6}};
  const Frame object = test::sphere_frame(camera, {0, 0, 0.6}, 0.1);
  const Frame hand = test::sphere_frame(camera, {0.12, 0, 0.5}, 0.04);
  DepthImage behind(camera.width, camera.height, 1.2f);
  const auto picture = [&](bool has_hand) {
    DepthImage depth = behind;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      for (const Frame* seen : {&object, &hand}) {
        const float z = seen->depth_m.pixels()[i];
        if (z > 0 && (seen == &object || has_hand)) depth.pixels()[i] = std::min(depth.pixels()[i], z);
      }
    }
    return depth;
  };
  LookThrough look(axis, noise());
  for (int i = 0; i < 24; ++i) look.add_witness(picture(i == 5), camera, 15 * kDegree * i);
  DepthImage seen = picture(true);
  look.remove_from(seen, camera, 75 * kDegree);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const float z = hand.depth_m.at(x, y);
      const bool is_there = !(z > 0) && object.depth_m.at(x, y) > 0;
      const bool is_left = seen.at(x, y) > 0 && (z > 0 || object.depth_m.at(x, y) > 0);
      EXPECT_EQ(is_left, is_there) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace scanknit
