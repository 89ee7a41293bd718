// The TUM RGB-D text layout: association, interpolation, and names that must not lead out of the folder.
#include <gtest/gtest.h>

#include <numbers>

#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

constexpr double kTiny = 1e-9;  // arithmetic in double

class TumRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    write_text(folder_ / "camera-intrinsics.txt", kMatrix);
    write_depth(folder_ / "depth/1.png", 5000);
    write_depth(folder_ / "depth/2.png", 5000);
  }
  [[nodiscard]] Played played(const AcquireConfig& config = {}) const { return play(folder_.path(), config); }

  TemporaryFolder folder_;
};

TEST_F(TumRecording, IsReadWithItsOwnScaleClockAndPoses) {
  write_text(folder_ / "depth.txt", "# depth\n1.5 depth/1.png\n2.5 depth/2.png\n");
  write_text(folder_ / "groundtruth.txt", "1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n");
  const Played p = played();
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].depth_m.at(0, 0), 1.0F);
  EXPECT_TRUE(p.frames[0].has_clock);
  EXPECT_EQ(p.frames[1].timestamp_ns, 2'500'000'000);
  EXPECT_TRUE(p.frames[1].T_world_camera->translation().isApprox(Eigen::Vector3d(4, 5, 6)));
}

TEST_F(TumRecording, KeepsMicrosecondsSince1970) {
  write_text(folder_ / "depth.txt", "1305031102.160407 depth/1.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  EXPECT_EQ(played(config).frames.at(0).timestamp_ns, 1'305'031'102'160'407'000);
}

TEST_F(TumRecording, MayHaveTabsAndCarriageReturns) {
  write_text(folder_ / "depth.txt", "# a comment\r\n\r\n1\tdepth/1.png\r\n2 \t depth/2.png\r\n");
  write_text(folder_ / "groundtruth.txt", "1\t0 0 0\t0 0 0 1\r\n2 0 0 0 0 0 0 1\r\n");
  EXPECT_EQ(played().frames.size(), 2u);
}

TEST_F(TumRecording, InterpolatesPosesBetweenStamps) {
  write_text(folder_ / "depth.txt", "1.0 depth/1.png\n");
  // A quarter turn about z from 0.99 to 1.03 s: a quarter of it has passed at 1.0.
  write_text(folder_ / "groundtruth.txt", "0.99 0 0 0 0 0 0 1\n1.03 4 0 0 0 0 0.70710678118 0.70710678118\n");
  const Pose pose = played().frames.at(0).T_world_camera.value();
  EXPECT_NEAR(pose.translation().x(), 1, 1e-6);
  EXPECT_NEAR(Eigen::AngleAxisd(pose.linear()).angle(), std::numbers::pi / 8, 1e-6);
}

TEST_F(TumRecording, TakesTheEndOfATrajectoryFor20Milliseconds) {
  write_text(folder_ / "depth.txt", "1.0 depth/1.png\n1.05 depth/2.png\n");
  write_text(folder_ / "groundtruth.txt", "0.981 7 0 0 0 0 0 1\n");
  const Played p = played();
  ASSERT_EQ(p.frames.size(), 1u);
  EXPECT_NEAR(p.frames[0].T_world_camera->translation().x(), 7, kTiny);
  EXPECT_EQ(p.reasons(), Reasons{"no_pose"});
}

TEST_F(TumRecording, DoesNotInterpolateAcrossAGap) {
  write_text(folder_ / "depth.txt", "5.0 depth/1.png\n");
  write_text(folder_ / "groundtruth.txt", "1 0 0 0 0 0 0 1\n9 0 0 0 0 0 0 1\n");
  AcquireConfig config;
  config.poses = PoseMode::kRecording;
  EXPECT_EQ(played(config).reasons(), Reasons{"no_pose"});
}

TEST_F(TumRecording, DropsFramesBesideABadPose) {
  write_text(folder_ / "depth.txt", "1.0 depth/1.png\n2.0 depth/2.png\n");
  write_text(folder_ / "groundtruth.txt", "1 nan 0 0 0 0 0 1\n2 0 0 0 0 0 0 0\n");
  const Played p = played();
  EXPECT_EQ(p.reasons(), (Reasons{"bad_pose", "bad_pose"}));
  EXPECT_NE(p.dropped[0].error.text().find("groundtruth.txt:1"), std::string::npos);
}

TEST_F(TumRecording, TreatsACutPoseLineAsABadPose) {
  write_text(folder_ / "depth.txt", "1.0 depth/1.png\n");
  write_text(folder_ / "groundtruth.txt", "1 0 0 0 0 0");
  EXPECT_EQ(played().reasons(), Reasons{"bad_pose"});
}

TEST_F(TumRecording, GivesEachColourPictureToOneFrameOnly) {
  write_colour(folder_ / "rgb/1.png", {1, 2, 3});
  write_text(folder_ / "depth.txt", "1.000 depth/1.png\n1.015 depth/2.png\n");
  write_text(folder_ / "rgb.txt", "1.010 rgb/1.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  const Played p = played(config);
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_FALSE(p.frames[0].colour.has_value());
  EXPECT_TRUE(p.frames[1].colour.has_value());
}

TEST_F(TumRecording, DoesNotPairColourBeyond20Milliseconds) {
  write_colour(folder_ / "rgb/1.png", {1, 2, 3});
  write_text(folder_ / "depth.txt", "1.000 depth/1.png\n");
  write_text(folder_ / "rgb.txt", "1.021 rgb/1.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  EXPECT_FALSE(played(config).frames.at(0).colour.has_value());
}

AcquireConfig still() {
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  return config;
}

TEST_F(TumRecording, WhoseTimeStepsBackIsReadInItsOrderAndLosesNoFrame) {
  std::string list;
  for (const char* time : {"10.0", "10.1", "10.2", "5.0", "5.1", "5.1", "7.1"}) {
    list += time + std::string(" depth/1.png\n");
  }
  write_text(folder_ / "depth.txt", list);
  auto source = open_recording(folder_.path(), still());
  ASSERT_TRUE(source) << source.error().text();
  ASSERT_EQ((*source)->info().warnings.size(), 1u);
  EXPECT_NE((*source)->info().warnings[0].find("step back or stand still 2 times"), std::string::npos);
  EXPECT_DOUBLE_EQ((*source)->info().duration_s.value(), 2.5);
  std::vector<std::int64_t> times_ms;
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  for (const Frame& frame : p.frames) times_ms.push_back(frame.timestamp_ns / 1'000'000);
  EXPECT_EQ(times_ms, (std::vector<std::int64_t>{10000, 10100, 10200, 10300, 10400, 10500, 12500}))
      << "the usual interval where the clock jumps, its own where it runs";
}

TEST_F(TumRecording, WhoseTimesLeadBeyondWhatFitsCountsItsFrames) {
  write_text(folder_ / "depth.txt",
             "9000000000 depth/1.png\n1 depth/1.png\n9000000000 depth/1.png\n9000000000 depth/1.png\n");
  const Played p = played(still());
  ASSERT_EQ(p.frames.size(), 4u);
  EXPECT_FALSE(p.frames[3].has_clock);
  EXPECT_EQ(p.frames[3].timestamp_ns, 3);
}

TEST_F(TumRecording, NamesTheLineWithoutATime) {
  write_text(folder_ / "depth.txt", "1 depth/1.png\nsoon depth/2.png\n");
  EXPECT_NE(open_error(folder_.path()).find("depth.txt:2"), std::string::npos);
}

TEST_F(TumRecording, WithNegativeFyKeepsItAndStandsUpright) {
  write_text(folder_ / "depth.txt", "1 depth/1.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  config.intrinsics = CameraModel{{0, 0, 481.2, -480, 319.5, 239.5}, {}};
  auto source = open_recording(folder_.path(), config);
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().world_up, UpAxis::kY);
  EXPECT_EQ((*source)->info().intrinsics->fy, -480);
}

TEST_F(TumRecording, RefusesAnAbsolutePath) {
  const std::string outside = (folder_ / "depth/2.png").string();
  write_text(folder_ / "depth.txt", "1 depth/1.png\n2 " + outside + "\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  const Played p = played(config);
  EXPECT_EQ(p.reasons(), Reasons{"unsafe_path"});
  EXPECT_NE(p.dropped[0].error.text().find("depth.txt:2"), std::string::npos);
}

TEST_F(TumRecording, RefusesToClimbOutOfItsFolder) {
  write_depth(folder_ / "secret.png", 1000);
  write_text(folder_ / "scene/depth.txt", "1 depth/../../secret.png\n2 ../secret.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  EXPECT_EQ(play(folder_ / "scene", config).reasons(), (Reasons{"unsafe_path", "unsafe_path"}));
}

TEST_F(TumRecording, RefusesASymbolicLinkOutOfItsFolder) {
  write_depth(folder_ / "secret.png", 1000);
  fs::create_directories(folder_ / "scene");
  fs::create_symlink("../secret.png", folder_ / "scene/link.png");
  write_text(folder_ / "scene/depth.txt", "1 link.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  EXPECT_EQ(play(folder_ / "scene", config).reasons(), Reasons{"unsafe_path"});
}

TEST_F(TumRecording, FollowsASymbolicLinkInsideItsFolder) {
  fs::create_symlink("depth/1.png", folder_ / "link.png");
  write_text(folder_ / "depth.txt", "1 link.png\n");
  AcquireConfig config;
  config.poses = PoseMode::kStill;
  EXPECT_EQ(played(config).frames.size(), 1u);
}

TEST_F(TumRecording, RefusesAnUnsafeColourPathToo) {
  write_text(folder_ / "depth.txt", "1 depth/1.png\n");
  write_text(folder_ / "rgb.txt", "1 /etc/passwd\n");
  EXPECT_EQ(played().reasons(), Reasons{"unsafe_path"});
}

TEST_F(TumRecording, DropsAFrameWhoseFileIsMissing) {
  write_text(folder_ / "depth.txt", "1 depth/9.png\n");
  const Played p = played();
  EXPECT_EQ(p.reasons(), Reasons{"missing_file"});
}

}  // namespace
}  // namespace scanknit::test
