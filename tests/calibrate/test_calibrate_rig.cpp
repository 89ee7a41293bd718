// Poses and clocks of a rig's cameras from corners with injected noise, against the truth.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "calibrate/calibrate_camera.h"
#include "calibrate/rig/calibrate_rig.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

constexpr CalibrationTarget kBoard{TargetType::kAprilGrid, 6, 4, 0.04};
constexpr int kRigSeeds = 10;

struct TrueCamera {
  CameraModel lens;
  Pose T_rig_camera = Pose::Identity();
  double clock_offset_s = 0;  ///< the rig's time is the camera's and this
};

Pose pose_of(const Eigen::Vector3d& position, const Eigen::Vector3d& turn_degrees) {
  Pose pose = Pose::Identity();
  pose.translation() = position;
  pose.linear() = (Eigen::AngleAxisd(turn_degrees.y() * kDegree, Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(turn_degrees.x() * kDegree, Eigen::Vector3d::UnitX()) *
                   Eigen::AngleAxisd(turn_degrees.z() * kDegree, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
  return pose;
}

/// Four cameras that look at one place 0.7 m before the first, with clocks of their own.
std::vector<TrueCamera> four_cameras() {
  const CameraModel lens{{640, 480, 531.2, 529.8, 322.7, 236.1}, {0.08, -0.21, 0.0011, -0.0007, 0}};
  std::vector<TrueCamera> cameras(4, {lens});
  cameras[1] = {lens, pose_of({0.35, 0.02, 0.05}, {1, -27, 2}), 3.217};
  cameras[2] = {lens, pose_of({-0.3, 0.05, 0.02}, {-3, 24, -4}), -1.0641};
  cameras[3] = {lens, pose_of({0.03, -0.32, 0.04}, {-25, 1, 90}), 0.0123};
  cameras[2].lens.intrinsics.fx = 540.1;
  cameras[3].lens.intrinsics.cy = 243.3;
  return cameras;
}

/// The board in a hand, as the rig sees it: `pace` 1 is calm, 0 holds it still.
Pose board_at(double time_s, std::uint64_t seed, double pace) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> evenly(0, 1);
  const auto wave = [&](double lowest_hz, double highest_hz) {
    const double hz = lowest_hz + (highest_hz - lowest_hz) * evenly(random);
    const double phase = 2 * std::numbers::pi * evenly(random);
    return std::sin(2 * std::numbers::pi * hz * time_s * pace + phase);
  };
  const Eigen::Vector3d middle(0.1 * wave(0.1, 0.3), 0.08 * wave(0.1, 0.3), 0.7 + 0.15 * wave(0.1, 0.3));
  const Eigen::Vector3d turn(25 * wave(0.1, 0.3), 25 * wave(0.1, 0.3), 30 * wave(0.05, 0.2));
  Pose pose = pose_of(middle, turn);
  const Eigen::Vector2d half = extent_m(kBoard) / 2;
  return pose * Eigen::Translation3d(-half.x(), -half.y(), 0);
}

struct Filming {
  std::uint64_t seed = 1;
  double noise_px = 0.1;
  double seconds = 20, frames_per_s = 15;
  double pace = 1;
  double phase = 0;  ///< of the pictures between those of another camera
};

std::vector<TimedView> film(const TrueCamera& camera, std::size_t number, const Filming& filming) {
  std::mt19937_64 random(filming.seed * 100 + number);
  std::normal_distribution<double> noise(0, filming.noise_px);
  const auto corners_m = target_corners(kBoard);
  const LensVector lens = lens_of(camera.lens);
  std::vector<TimedView> views;
  for (int i = 0; i < static_cast<int>(filming.seconds * filming.frames_per_s); ++i) {
    const double rig_s = (i + filming.phase) / filming.frames_per_s;
    const Pose T_camera_board = camera.T_rig_camera.inverse() * board_at(rig_s, filming.seed, filming.pace);
    TimedView view{rig_s - camera.clock_offset_s, {}};
    for (std::size_t k = 0; k < corners_m.size(); ++k) {
      const Eigen::Vector3d p = T_camera_board * Eigen::Vector3d(corners_m[k].x(), corners_m[k].y(), 0);
      const Eigen::Vector2d pixel = project(lens, p).pixel + Eigen::Vector2d(noise(random), noise(random));
      const bool is_inside = pixel.x() > 0 && pixel.y() > 0 && pixel.x() < 639 && pixel.y() < 479;
      if (is_inside) view.corners.push_back({static_cast<int>(k), pixel});
    }
    if (view.corners.size() >= kFewestCorners) views.push_back(std::move(view));
  }
  return views;
}

/// Its own calibration from the same pictures.
CameraModel calibrated(const std::vector<TimedView>& views) {
  std::vector<BoardView> boards;
  for (const TimedView& view : views) boards.push_back({"", view.corners, 0.4});
  const auto found = calibrate_camera(boards, kBoard, {640, 480});
  EXPECT_TRUE(found) << found.error().text();
  return found->camera;
}

enum class Lenses { kKnown, kCalibrated };

std::vector<RigRecording> record(const std::vector<TrueCamera>& cameras, Filming filming, Lenses lenses) {
  std::vector<RigRecording> recordings;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    filming.phase = 0.23 * static_cast<double>(i);  // cameras that run freely
    RigRecording recording{.name = "camera " + std::to_string(i), .lens = cameras[i].lens, .is_lens_known = true};
    recording.views = film(cameras[i], i, filming);
    if (lenses == Lenses::kCalibrated) {
      recording.lens = calibrated(recording.views);
      recording.is_lens_known = false;
    }
    recordings.push_back(std::move(recording));
  }
  return recordings;
}

double turn_between(const Pose& a, const Pose& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

TEST(CalibrateRig, FindsFourCamerasWithClocksOfTheirOwnWithinItsDeviations) {
  const auto truth = four_cameras();
  double worst_mm = 0, worst_degrees = 0, worst_ms = 0;
  int numbers = 0, beyond_three = 0;
  for (int seed = 1; seed <= kRigSeeds; ++seed) {
    const auto recordings =
        record(truth, {.seed = static_cast<std::uint64_t>(seed), .seconds = 12}, Lenses::kCalibrated);
    const auto found = calibrate_rig(recordings, kBoard);
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_TRUE(found->cameras[0].T_rig_camera.isApprox(Pose::Identity()));
    EXPECT_EQ(found->cameras[0].clock_offset_s, 0);
    for (std::size_t i = 1; i < truth.size(); ++i) {
      const FoundCamera& camera = found->cameras[i];
      const double off_m = (camera.T_rig_camera.translation() - truth[i].T_rig_camera.translation()).norm();
      const double off_rad = turn_between(camera.T_rig_camera, truth[i].T_rig_camera);
      const double off_s = std::abs(camera.clock_offset_s - truth[i].clock_offset_s);
      EXPECT_LT(off_m, 0.0005) << "seed " << seed << ", camera " << i;
      EXPECT_LT(off_rad, 0.05 * kDegree) << "seed " << seed << ", camera " << i;
      EXPECT_LT(off_s, 0.001) << "seed " << seed << ", camera " << i;
      worst_mm = std::max(worst_mm, 1000 * off_m);
      worst_degrees = std::max(worst_degrees, off_rad / kDegree);
      worst_ms = std::max(worst_ms, 1000 * off_s);
      numbers += 3;
      beyond_three += off_m > 3 * camera.position_deviation_m ? 1 : 0;
      beyond_three += off_rad > 3 * camera.turn_deviation_rad ? 1 : 0;
      beyond_three += off_s > 3 * camera.clock_deviation_s ? 1 : 0;
    }
  }
  RecordProperty("worst_mm", std::to_string(worst_mm));
  RecordProperty("worst_degrees", std::to_string(worst_degrees));
  RecordProperty("worst_ms", std::to_string(worst_ms));
  EXPECT_LE(beyond_three, numbers / 100 + 1) << "of " << numbers;
}

TEST(CalibrateRig, IsExactWithoutNoiseAtKnownLensesAndOneTrigger) {
  auto truth = four_cameras();
  for (TrueCamera& camera : truth) camera.clock_offset_s = 0;
  const Filming filming{.noise_px = 0, .seconds = 4};
  auto recordings = record(truth, filming, Lenses::kKnown);
  for (std::size_t i = 0; i < truth.size(); ++i) recordings[i].views = film(truth[i], i, filming);
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_TRUE(found) << found.error().text();
  for (std::size_t i = 1; i < truth.size(); ++i) {
    EXPECT_TRUE(found->cameras[i].T_rig_camera.isApprox(truth[i].T_rig_camera, 1e-6)) << i;
    EXPECT_NEAR(found->cameras[i].clock_offset_s, 0, 1e-6) << i;
  }
}

TEST(CalibrateRig, WithoutClocksPicturesOfOneNumberAreTakenTogether) {
  auto truth = four_cameras();
  std::vector<RigRecording> recordings;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].clock_offset_s = 0;
    RigRecording recording{.name = "", .lens = truth[i].lens, .is_lens_known = true, .has_clock = false};
    recording.views = film(truth[i], i, {.frames_per_s = 3});
    for (TimedView& view : recording.views) view.time_s = std::round(view.time_s * 3);  // their numbers
    recordings.push_back(std::move(recording));
  }
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_TRUE(found) << found.error().text();
  for (std::size_t i = 1; i < truth.size(); ++i) {
    EXPECT_LT((found->cameras[i].T_rig_camera.translation() - truth[i].T_rig_camera.translation()).norm(), 0.0005);
    EXPECT_EQ(found->cameras[i].clock_offset_s, 0);
  }
}

TEST(CalibrateRig, ACameraMayBeJoinedByWayOfAnother) {
  auto truth = four_cameras();
  auto recordings = record(truth, {}, Lenses::kKnown);
  recordings.erase(recordings.begin() + 3);
  // The board is shown to the first two, and then to the last two.
  std::erase_if(recordings[0].views, [&](const TimedView& view) { return view.time_s > 10; });
  std::erase_if(recordings[2].views, [&](const TimedView& view) { return view.time_s + truth[2].clock_offset_s < 10; });
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_TRUE(found) << found.error().text();
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_LT((found->cameras[i].T_rig_camera.translation() - truth[i].T_rig_camera.translation()).norm(), 0.001);
    EXPECT_NEAR(found->cameras[i].clock_offset_s, truth[i].clock_offset_s, 0.001);
  }
}

TEST(CalibrateRig, LeavesOutWrongCorners) {
  const auto truth = four_cameras();
  auto recordings = record(truth, {}, Lenses::kKnown);
  for (std::size_t i = 0; i < recordings[1].views.size(); i += 5) recordings[1].views[i].corners[7].pixel.x() += 8;
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_GE(found->outlying_corners, 20u);
  EXPECT_LT((found->cameras[1].T_rig_camera.translation() - truth[1].T_rig_camera.translation()).norm(), 0.0005);
}

TEST(CalibrateRig, RefusesACameraThatSharesNoView) {
  auto recordings = record(four_cameras(), {}, Lenses::kKnown);
  std::erase_if(recordings[2].views, [](const TimedView& view) { return view.time_s < 18; });  // at another time
  for (std::size_t i : {0, 1, 3}) {
    std::erase_if(recordings[i].views, [](const TimedView& view) { return view.time_s > 12; });
  }
  for (TimedView& view : recordings[2].views) view.corners = recordings[2].views.front().corners;  // at rest
  recordings[2].views.resize(5);
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kTooLittle);
  EXPECT_NE(found.error().message.find("camera 2"), std::string::npos) << found.error().message;
  EXPECT_NE(found.error().message.find("expected at least 8"), std::string::npos) << found.error().message;
}

TEST(CalibrateRig, RefusesClocksThatDoNotOverlapBeforeABoardAtRest) {
  auto truth = four_cameras();
  truth[1].clock_offset_s = 1000;
  auto recordings = record(truth, {.pace = 0}, Lenses::kKnown);
  recordings.resize(2);
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kInput);
  EXPECT_NE(found.error().message.find("do not overlap"), std::string::npos) << found.error().message;
}

TEST(CalibrateRig, RefusesClocksOnlySomeHave) {
  auto recordings = record(four_cameras(), {}, Lenses::kKnown);
  recordings[3].has_clock = false;
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kInput);
  EXPECT_NE(found.error().message.find("time stamps"), std::string::npos) << found.error().message;
}

TEST(CalibrateRig, RefusesCamerasThatMoveAgainstEachOther) {
  const auto truth = four_cameras();
  auto recordings = record(truth, {}, Lenses::kKnown);
  const auto other = record({truth[0], {truth[0].lens, pose_of({0.1, 0.2, 0}, {20, 10, 45}), 0}}, {.seed = 77},
                            Lenses::kKnown);  // of another board
  recordings[2].views = other[1].views;
  const auto found = calibrate_rig(recordings, kBoard);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kTooLittle) << found.error().message;
}

}  // namespace
}  // namespace scanknit
