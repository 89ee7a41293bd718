// A person is told before tracking is lost.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/live/tracking_watch.h"
#include "scan/scan.h"
#include "synth/scene/scene.h"
#include "synth/synthetic_source.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr std::size_t kMany = kWidth * kHeight / 2, kFew = kWidth * kHeight / 20;

/// Frame n of a camera at 30 frames a second that sees a wall.
Frame frame_of(int n, float depth_m) {
  Frame frame;
  frame.intrinsics = {kWidth, kHeight, 52.5, 52.5, 31.5, 23.5};
  frame.depth_m = DepthImage(kWidth, kHeight, depth_m);
  frame.timestamp_ns = n * 33'333'333LL;
  frame.has_clock = true;
  return frame;
}

Pose turned(double rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

Pose moved(double m) {
  Pose pose = Pose::Identity();
  pose.translation().x() = m;
  return pose;
}

std::string reason_of(const std::optional<TrackingCaution>& caution) {
  return caution ? caution->reason : "";
}

TEST(TrackingWatch, IsSilentWhileTheCameraMovesSlowlyAndSeesMuch) {
  TrackingWatch watch;
  for (int n = 0; n < 5; ++n) EXPECT_FALSE(watch.look(frame_of(n, 2), turned(0.02 * n), kMany)) << n;
}

TEST(TrackingWatch, WarnsOfAFastTurn) {
  TrackingWatch watch;
  EXPECT_FALSE(watch.look(frame_of(0, 2), turned(0), kMany));
  EXPECT_EQ(reason_of(watch.look(frame_of(1, 2), turned(0.05), kMany)), "moving fast");
  EXPECT_FALSE(watch.look(frame_of(2, 2), turned(0.06), kMany)) << "it has become slow";
}

TEST(TrackingWatch, WarnsOfAFastMoveCloseToTheSurfaceOnly) {
  TrackingWatch close, far;
  EXPECT_FALSE(close.look(frame_of(0, 0.8f), moved(0), kMany));
  EXPECT_EQ(reason_of(close.look(frame_of(1, 0.8f), moved(0.04), kMany)), "moving fast");
  EXPECT_FALSE(far.look(frame_of(0, 3), moved(0), kMany));
  EXPECT_FALSE(far.look(frame_of(1, 3), moved(0.04), kMany));
}

TEST(TrackingWatch, DoesNotTakeAGapForAFastMove) {
  TrackingWatch watch;
  EXPECT_FALSE(watch.look(frame_of(0, 2), turned(0), kMany));
  EXPECT_FALSE(watch.look(frame_of(30, 2), turned(0.5), kMany));
  watch.reset();
  EXPECT_FALSE(watch.look(frame_of(31, 2), turned(1), kMany));
}

TEST(TrackingWatch, WarnsWhenLittleIsSeen) {
  TrackingWatch watch;
  EXPECT_EQ(reason_of(watch.look(frame_of(0, 2), turned(0), kFew)), "little is seen");
  EXPECT_EQ(reason_of(watch.look(frame_of(1, 0.5f), turned(0), kFew)), "very close");
}

/// A Kinect in a hand that goes round the desk in so many frames.
SynthConfig kinect_in_hand(int frames, PathKind path, int width, int height) {
  SynthConfig config;
  config.frames = frames;
  config.sensor = *make_sensor("kinect1");
  config.intrinsics = camera_of(*config.sensor, width, height);
  config.path = path;
  config.seed = 3;
  return config;
}

TEST(TrackingWatch, IsSilentWhileAHandGoesRoundADesk) {
  auto scene = make_scene("desk");
  ASSERT_TRUE(scene);
  const auto source = SyntheticSource::create(*std::move(scene), kinect_in_hand(480, PathKind::kHand, 160, 120));
  ASSERT_TRUE(source);
  TrackingWatch watch;
  for (int n = 0; n < 90; ++n) {
    FrameEvent event = (*source)->next({});
    ASSERT_TRUE(std::holds_alternative<Frame>(event));
    const Frame& frame = std::get<Frame>(event);
    ASSERT_TRUE(frame.has_clock && frame.T_world_camera);
    EXPECT_EQ(reason_of(watch.look(frame, *frame.T_world_camera, kMany * 20)), "") << n;
  }
}

/// Keeps for each frame whether it is lost, and whether it was warned of.
class Listener final : public ScanObserver {
 public:
  void on_frame(const Frame& frame, const std::optional<Pose>& T_world_camera, const ScanState& scan) override {
    const bool warns = T_world_camera && watch_.look(frame, *T_world_camera, scan.newest->points);
    if (!T_world_camera) watch_.reset();
    frames.push_back({!T_world_camera, warns});
  }

  struct Seen {
    bool is_lost, warns;
  };
  std::vector<Seen> frames;

 private:
  TrackingWatch watch_;
};

TEST(TrackingWatch, WarnsBeforeAQuickTurnLosesTheCamera) {
  // A Kinect that is turned by up to 120 degrees a second and read row by row, which the scan is not told.
  const SynthConfig config = kinect_in_hand(110, PathKind::kTurns, 320, 240);
  const auto folder = std::filesystem::temp_directory_path() / ("scanknit_quick_turn_" + std::to_string(::getpid()));
  const auto scene = make_scene("desk");
  ASSERT_TRUE(scene);
  ASSERT_TRUE(write_synthetic_recording(**scene, config, folder));
  ScanJob job;
  job.input = folder;
  job.config.acquire.poses = PoseMode::kTrack;
  job.config.acquire.readout_s = 0;
  job.config.acquire.colour_later_s = 0;
  job.config.fusion.voxel_size_m = 0.01;
  Listener listener;
  const ScanResult result = scan_recording(job, listener);
  std::filesystem::remove_all(folder);
  const auto& frames = listener.frames;
  const auto first_lost = std::find_if(frames.begin(), frames.end(), [](const auto& seen) { return seen.is_lost; });
  ASSERT_NE(first_lost, frames.end()) << "no frame is lost: this shows nothing";
  ASSERT_GE(first_lost - frames.begin(), 3);
  for (int before = 1; before <= 3; ++before) EXPECT_TRUE(first_lost[-before].warns) << before << " frames before";
}

}  // namespace
}  // namespace scanknit
