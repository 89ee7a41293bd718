// Scans during which something comes, goes or moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "fusion/integrate/integrate.h"
#include "fusion/track/tracker.h"
#include "tests/app/small_scan.h"

namespace scanknit {
namespace {

constexpr double kVoxel_m = 0.01;

/// A striped board that is 13 cm wide and stands upright, 0.6 m before a camera at `T_world_eye`, beside the middle.
void add_board(Frame& frame, const Pose& T_world_eye, double aside_m) {
  constexpr double kAway_m = 0.6, kWidth_m = 0.13;
  const Pose T_eye_camera = T_world_eye.inverse() * *frame.T_world_camera;
  for (int y = 0; y < frame.depth_m.height(); ++y) {
    for (int x = 0; x < frame.depth_m.width(); ++x) {
      const Eigen::Vector3d along = frame.intrinsics.unproject(x, y, 1);
      const double z_m = (kAway_m - T_eye_camera.translation().z()) / (T_eye_camera.linear() * along).z();
      const double across_m = (T_eye_camera * (z_m * along)).x() - aside_m;
      if (!(z_m > 0.3 && across_m >= 0 && across_m < kWidth_m)) continue;
      frame.depth_m.at(x, y) = static_cast<float>(z_m);
      const bool is_bright = static_cast<int>(across_m / 0.02) % 2 == 0;
      frame.colour->image.at(x, y) = is_bright ? Rgb8{200, 200, 200} : Rgb8{90, 90, 90};
    }
  }
}

struct Tracked {
  std::vector<TrackResult> frames;
  double worst_m = 0;  ///< of the poses of frames that were not lost
};

/// Tracked as a recording's prior says, and fused.
Tracked track(const std::vector<Frame>& frames, PosePrior prior, const FusionConfig& config) {
  Tracked tracked;
  auto volume = TsdfVolume::create(config);
  if (!volume) return tracked;
  Tracker tracker({.prior = prior});
  for (const Frame& frame : frames) {
    tracked.frames.push_back(tracker.track(frame, *volume));
    const TrackResult& result = tracked.frames.back();
    if (result.is_lost()) continue;
    const Eigen::Vector3d off = result.T_world_camera.translation() - frame.T_world_camera->translation();
    tracked.worst_m = std::max(tracked.worst_m, off.norm());
    if (!integrate(frame, result.T_world_camera, *volume)) break;
  }
  return tracked;
}

class Changes : public ::testing::TestWithParam<PosePrior> {
 protected:
  void SetUp() override { config_.voxel_size_m = kVoxel_m; }
  FusionConfig config_;
};

TEST_P(Changes, WhoPassesDoesNotTakeTheCameraAlong) {
  constexpr std::size_t kComes = 8, kGone = 25;
  const auto frames = test::small_scan("desk", 40, 120, config_.noise, [](std::size_t i, Frame& frame) {
    if (i >= kComes && i < kGone)
      add_board(frame, *frame.T_world_camera, -0.5 + 0.05 * static_cast<double>(i - kComes));
  });
  const Tracked tracked = track(frames, GetParam(), config_);
  ASSERT_EQ(tracked.frames.size(), 40u);
  EXPECT_LT(tracked.worst_m, kVoxel_m);  // what is fused while half of the picture changes stays one surface
  const auto left_out = std::count_if(tracked.frames.begin(), tracked.frames.end(), [](const TrackResult& frame) {
    return frame.reason == TrackReason::kSceneIsChanging;
  });
  EXPECT_EQ(left_out > 0, GetParam() == PosePrior::kIgnore);
  for (std::size_t i = 0; i < tracked.frames.size(); ++i) {
    const TrackResult& result = tracked.frames[i];
    if (i >= kComes && i < kGone + 5) continue;
    EXPECT_EQ(result.state, TrackState::kOk) << i << ": " << to_string(result.reason);
  }
}

TEST_P(Changes, WhatComesOrGoesAtOnceIsNoReasonToBeLost) {
  constexpr std::size_t kGoes = 10, kComes = 25;
  std::optional<Pose> T_world_first;
  const auto frames = test::small_scan("desk", 40, 1200, config_.noise, [&](std::size_t i, Frame& frame) {
    if (!T_world_first) T_world_first = frame.T_world_camera;
    if (i < kGoes || i >= kComes) add_board(frame, *T_world_first, 0.05);
  });
  const Tracked tracked = track(frames, GetParam(), config_);
  ASSERT_EQ(tracked.frames.size(), 40u);
  EXPECT_LT(tracked.worst_m, kVoxel_m / 2);
  for (std::size_t i = 0; i < tracked.frames.size(); ++i) {
    EXPECT_FALSE(tracked.frames[i].is_lost()) << i << ": " << to_string(tracked.frames[i].reason);
  }
}

INSTANTIATE_TEST_SUITE_P(Poses, Changes, ::testing::Values(PosePrior::kIgnore, PosePrior::kRefine),
                         [](const auto& prior) {
                           return std::string(prior.param == PosePrior::kIgnore ? "Tracked" : "Refined");
                         });

}  // namespace
}  // namespace scanknit
