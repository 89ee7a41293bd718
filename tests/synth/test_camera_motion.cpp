#include <gtest/gtest.h>

#include <cmath>

#include "core/rotation.h"
#include "synth/path/motion.h"
#include "synth/path/recorded_motion.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

constexpr double kRate_hz = 30;
constexpr int kFrames = 900;  // 30 s

Pose still(double) {
  return Pose::Identity();
}

/// Ten metres to the right.
Pose straight(double s) {
  Pose pose = Pose::Identity();
  pose.translation().x() = 10 * s;
  return pose;
}

Motion motion(const CameraPath& path, PathKind kind, std::uint64_t seed = 1) {
  return make_motion(path, {kind, kFrames, kRate_hz, seed});
}

double angle_deg(const Eigen::Matrix3d& rotation) {
  return Eigen::AngleAxisd(rotation).angle() / kDegree;
}

TEST(CameraMotion, OfTheSceneIsItsPathBitByBit) {
  const auto scene = *make_scene("desk");
  const Motion flown = make_motion(scene->path(), {PathKind::kScene, 97, kRate_hz, 1});
  const auto poses = camera_path(*scene, 97);
  for (int i = 0; i < 97; ++i) {
    EXPECT_EQ(flown(i).matrix(), poses[static_cast<std::size_t>(i)].matrix()) << i;
  }
}

class HandKinds : public ::testing::TestWithParam<PathKind> {};
INSTANTIATE_TEST_SUITE_P(All, HandKinds,
                         ::testing::Values(PathKind::kHand, PathKind::kTurns, PathKind::kWalk, PathKind::kOrbit));

TEST_P(HandKinds, RepeatForASeedAndDifferForAnother) {
  EXPECT_EQ(motion(straight, GetParam())(123.4).matrix(), motion(straight, GetParam())(123.4).matrix());
  EXPECT_NE(motion(straight, GetParam())(123.4).matrix(), motion(straight, GetParam(), 2)(123.4).matrix());
}

TEST_P(HandKinds, AreRigidAndSmooth) {
  const Motion hand = motion(straight, GetParam());
  const double step = 0.001 * kRate_hz;  // a millisecond
  for (double frame = 0; frame < kFrames; frame += 3.7) {
    const Pose a = hand(frame);
    const Pose b = hand(frame + step);
    const Pose c = hand(frame + 2 * step);
    EXPECT_TRUE(is_rigid(a));
    // Tremor alone accelerates by a few m/s^2. A jump of 0.1 mm or 0.01 degrees would be ten times as much.
    constexpr double kStep2_s2 = 1e-6;
    EXPECT_LT((a.translation() - 2 * b.translation() + c.translation()).norm(), 10 * kStep2_s2) << frame;
    const Eigen::Matrix3d change = (a.inverse() * b).linear().transpose() * (b.inverse() * c).linear();
    EXPECT_LT(angle_deg(change), 2000 * kStep2_s2) << frame;
  }
}

TEST(HandPath, TremblesByMillimetresAndAboutADegree) {
  const Motion hand = motion(still, PathKind::kHand);
  double shift = 0;
  double turn = 0;
  for (int i = 0; i < kFrames; ++i) {
    shift += hand(i).translation().squaredNorm() / kFrames;
    turn += std::pow(angle_deg(hand(i).linear()), 2) / kFrames;
  }
  EXPECT_NEAR(std::sqrt(shift), 0.006 * std::sqrt(3.0), 0.003);
  EXPECT_NEAR(std::sqrt(turn), 0.8 * std::sqrt(3.0), 0.4);
}

TEST(TurnsPath, TurnsSuddenlyButNeverFasterThan120DegreesASecond) {
  const Motion hand = motion(still, PathKind::kHand);
  const Motion turns = motion(still, PathKind::kTurns);
  // Both tremble alike: what is left is the looking aside.
  const auto aside = [&](double frame) {
    return Eigen::Matrix3d(turns(frame).linear() * hand(frame).linear().transpose());
  };
  double fastest = 0;
  double farthest = 0;
  for (double frame = 0; frame < kFrames; frame += 0.25) {
    const double rate = angle_deg(aside(frame).transpose() * aside(frame + 0.01)) / (0.01 / kRate_hz);
    fastest = std::max(fastest, rate);
    farthest = std::max(farthest, angle_deg(aside(frame)));
  }
  EXPECT_LT(fastest, 120.5);
  EXPECT_GT(fastest, 90);
  EXPECT_GT(farthest, 40);
  EXPECT_LT(farthest, 75.5);
}

TEST(WalkPath, StopsOnTheWayAndArrives) {
  const Motion walk = motion(straight, PathKind::kWalk);
  double slowest_m_s = 1;
  for (int i = 0; i + 15 < kFrames; ++i) {
    slowest_m_s = std::min(slowest_m_s, (walk(i + 15).translation().x() - walk(i).translation().x()) / 0.5);
  }
  EXPECT_LT(slowest_m_s, 0.06);  // what the sway may be
  EXPECT_NEAR(walk(0).translation().x(), 0, 0.05);
  EXPECT_NEAR(walk(kFrames).translation().x(), 10, 0.05);
}

TEST(OrbitPath, CirclesWithinAHandsReachOfTheBeginning) {
  const Motion orbit = motion(straight, PathKind::kOrbit);
  double farthest = 0;
  for (int i = 0; i < kFrames; ++i) farthest = std::max(farthest, orbit(i).translation().norm());
  EXPECT_GT(farthest, 0.12);
  EXPECT_LT(farthest, 0.25);
}

constexpr const char* kPath =
    "# time tx ty tz qx qy qz qw\n"
    "1305031229.00 5 6 7 0 0 0 1\n"
    "1305031230.00 5 6 8 0 0 0.70710678 0.70710678\n"
    "1305031232.00 5 6 8 0 0 0.70710678 0.70710678\n";

TEST(RecordedPath, IsFlownFromTheScenesBeginning) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "path.txt", kPath);
  const auto path = read_recorded_path(folder / "path.txt");
  ASSERT_TRUE(path) << path.error().text();
  ASSERT_EQ(path->size(), 3u);
  EXPECT_NEAR(path->back().time_s, 3, 1e-6);
  Pose begin = Pose::Identity();
  begin.translation() = Eigen::Vector3d(1, 2, 3);
  const Motion flown = fly_again(*path, begin, kRate_hz);
  EXPECT_NEAR((flown(0).translation() - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-9);
  EXPECT_NEAR((flown(15).translation() - Eigen::Vector3d(1, 2, 3.5)).norm(), 0, 1e-6);
  EXPECT_NEAR(angle_deg(flown(15).linear()), 45, 1e-3);
  EXPECT_NEAR((flown(1000).translation() - Eigen::Vector3d(1, 2, 4)).norm(), 0, 1e-9) << "stands still beyond its end";
}

TEST(RecordedPath, IsRefusedWithItsLine) {
  const test::TemporaryFolder folder;
  const auto message = [&](const std::string& text) {
    test::write_text(folder / "path.txt", text);
    const auto path = read_recorded_path(folder / "path.txt");
    return path ? std::string() : path.error().text();
  };
  const std::string first = "1 0 0 0 0 0 0 1\n";
  EXPECT_NE(message(first + "2 0 0 0 0 0 1\n").find("path.txt:2"), std::string::npos);
  EXPECT_NE(message(first + "2 0 0 nan 0 0 0 1\n").find("path.txt:2"), std::string::npos);
  EXPECT_NE(message(first + "2 0 0 0 0 0 0 0\n").find("length is not 1"), std::string::npos);
  EXPECT_NE(message(first + "1 0 0 0 0 0 0 1\n").find("after that of the line above"), std::string::npos);
  EXPECT_NE(message(first).find("at least two poses"), std::string::npos);
}

TEST(RecordedPath, IsRefusedWhenCutShortInALine) {
  const test::TemporaryFolder folder;
  const std::string whole = kPath;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    test::write_text(folder / "path.txt", whole.substr(0, size));
    const auto path = read_recorded_path(folder / "path.txt");  // no crash; what is read is a part of the path
    if (path) {
      EXPECT_LE(path->size(), 3u);
    }
  }
}

}  // namespace
}  // namespace scanknit
