// The 7-Scenes, Open3D and phone layouts: numbers, cameras, poses, axes.
#include <gtest/gtest.h>

#include "test_replay_support.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

constexpr double kTiny = 1e-9;  // arithmetic in double

TEST(SevenScenes, KeepsTheRecordingsFrameNumbers) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  write_depth(folder / seven_scenes_name(422, "depth.png"), 2000);
  write_text(folder / seven_scenes_name(422, "pose.txt"), "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n");
  const Played played = play(folder.path());
  ASSERT_EQ(played.frames.size(), 2u);
  EXPECT_EQ(played.frames[1].sequence, 422u);
  EXPECT_FALSE(played.frames[1].has_clock);
  EXPECT_EQ(played.frames[1].depth_m.at(7, 5), 2.0F);
  EXPECT_TRUE(played.frames[1].T_world_camera->translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST(SevenScenes, ScalesTheCameraToLargerColour) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 1);
  write_colour(folder / seven_scenes_name(0, "color.jpg"), {10, 20, 30}, 2 * kWidth, 2 * kHeight);
  const auto colour = play(folder.path()).frames.at(0).colour.value();
  EXPECT_EQ(colour.intrinsics, (CameraIntrinsics{16, 12, 200, 200, 7.5, 5.5}));
}

TEST(SevenScenes, DescribesItself) {
  const TemporaryFolder folder;
  write_seven_scenes(folder.path(), 3);
  fs::remove(folder / seven_scenes_name(2, "pose.txt"));
  const auto source = open_recording(folder.path(), {});
  ASSERT_TRUE(source);
  const RecordingInfo& info = (*source)->info();
  EXPECT_EQ(info.format, "7-scenes");
  EXPECT_EQ(info.frames, 3u);
  EXPECT_EQ(info.frames_with_pose, 2u);
  EXPECT_FALSE(info.has_colour);
  EXPECT_FALSE(info.duration_s.has_value());
  EXPECT_EQ(info.world_up, UpAxis::kMinusY);
}

constexpr const char* kCameraJson =
    R"({"width": 8, "height": 6, "intrinsic_matrix": [100, 0, 0, 0, 110, 0, 3.5, 2.5, 1]})";

class Open3dRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    write_text(folder_ / "camera_intrinsic.json", kCameraJson);
    std::string log;
    for (int i = 0; i < 3; ++i) {
      write_depth(folder_ / ("depth/0000" + std::to_string(i) + ".png"), 1500);
      const std::string n = std::to_string(i);
      log += n + " " + n + " " + std::to_string(i + 1) + "\n1 0 0 " + n + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    }
    write_text(folder_ / "trajectory.log", log);
  }
  TemporaryFolder folder_;
};

TEST_F(Open3dRecording, IsReadWithItsCameraAndPoses) {
  const Played played = play(folder_.path());
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_EQ(played.frames[0].intrinsics, (CameraIntrinsics{8, 6, 100, 110, 3.5, 2.5}));
  EXPECT_EQ(played.frames[2].depth_m.at(0, 0), 1.5F);
  EXPECT_NEAR(played.frames[2].T_world_camera->translation().x(), 2, kTiny);
}

TEST_F(Open3dRecording, PairsColourByNameWhereNamesAgree) {
  write_colour(folder_ / "color/00001.png", {1, 2, 3});
  const Played played = play(folder_.path());
  EXPECT_FALSE(played.frames.at(0).colour.has_value());
  EXPECT_TRUE(played.frames.at(1).colour.has_value());
}

TEST_F(Open3dRecording, PairsColourByOrderWhereNoNameAgrees) {
  for (int i = 0; i < 3; ++i) {
    write_colour(folder_ / ("image/c" + std::to_string(9 + i) + ".png"), {static_cast<std::uint8_t>(i), 0, 0});
  }
  const Played played = play(folder_.path());
  EXPECT_EQ(played.frames.at(2).colour->image.at(0, 0).r, 2);
}

TEST_F(Open3dRecording, DoesNotGuessWhichColourBelongsToWhichDepth) {
  write_colour(folder_ / "image/c.png", {0, 0, 0});
  EXPECT_NE(open_error(folder_.path()).find("1 colour pictures for 3 depth pictures"), std::string::npos);
}

TEST_F(Open3dRecording, KeepsPosesWithTheirFramesWhenOneIsMissing) {
  fs::remove(folder_ / "depth/00001.png");
  const Played played = play(folder_.path());
  ASSERT_EQ(played.reasons(), Reasons{"missing_file"});
  EXPECT_NE(played.dropped[0].error.text().find("00001.png"), std::string::npos);
  ASSERT_EQ(played.frames.size(), 2u);
  EXPECT_NEAR(played.frames[1].T_world_camera->translation().x(), 2, kTiny);
}

TEST_F(Open3dRecording, DropsFramesBeyondACutTrajectory) {
  write_text(folder_ / "trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 1 2\n1 0 0 0\n0 1");
  EXPECT_EQ(play(folder_.path()).reasons(), (Reasons{"bad_pose", "no_pose"}));
}

TEST_F(Open3dRecording, ReadsOpen3dsJsonTrajectoryAsWorldToCamera) {
  fs::remove(folder_ / "trajectory.log");
  const std::string pose = R"({"extrinsic": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1]})";
  write_text(folder_ / "trajectory.json", R"({"parameters": [)" + pose + "," + pose + "," + pose + "]}");
  const Played played = play(folder_.path());
  ASSERT_EQ(played.frames.size(), 3u);
  EXPECT_NEAR(played.frames[0].T_world_camera->translation().x(), -5, kTiny);
}

TEST_F(Open3dRecording, ReadsOptionalTimes) {
  write_text(folder_ / "timestamps.txt", "10.5\n10.6\n10.75\n");
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source);
  EXPECT_NEAR((*source)->info().duration_s.value(), 0.25, kTiny);
  EXPECT_EQ(play(**source).frames.at(1).timestamp_ns, 10'600'000'000);
}

TEST_F(Open3dRecording, TakesTheDepthScaleThatTheSyntheticScannerStates) {
  write_text(folder_ / "camera_intrinsic.json",
             R"({"width": 8, "height": 6, "intrinsic_matrix": [100, 0, 0, 0, 110, 0, 3.5, 2.5, 1],
                 "depth_scale": 10000})");
  EXPECT_EQ(play(folder_.path()).frames.at(0).depth_m.at(0, 0), 0.15F);
}

TEST_F(Open3dRecording, RefusesACameraFileThatIsNoJson) {
  write_text(folder_ / "camera_intrinsic.json", R"({"intrinsic_matrix": [1, 2)");
  EXPECT_NE(open_error(folder_.path()).find("camera_intrinsic.json: not a camera"), std::string::npos);
}

TEST_F(Open3dRecording, OfAnotherSizeThanItsCameraIsDropped) {
  write_text(folder_ / "camera_intrinsic.json",
             R"({"width": 9, "height": 6, "intrinsic_matrix": [100, 0, 0, 0, 110, 0, 3.5, 2.5, 1]})");
  EXPECT_EQ(play(folder_.path()).reasons(), (Reasons{"size_mismatch", "size_mismatch", "size_mismatch"}));
}

class PhoneRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    write_depth(folder_ / "depth_00006.png", 3000);
    write_grey8(folder_ / "conf_00006.png", 2);
    write_colour(folder_ / "frame_00006.jpg", {80, 90, 100}, 2 * kWidth, 2 * kHeight);
    write_text(folder_ / "frame_00006.json", json("1,0,0,7, 0,1,0,8, 0,0,1,9, 0,0,0,1"));
  }
  [[nodiscard]] static std::string json(const std::string& pose) {
    return R"({"cameraPoseARFrame": [)" + pose + R"(], "intrinsics": [1584,0,948, 0,1584,720, 0,0,1], "time": 12.5})";
  }
  TemporaryFolder folder_;
};

TEST_F(PhoneRecording, ScalesTheSensorsCameraToEachPicture) {
  const Frame frame = play(folder_.path()).frames.at(0);
  EXPECT_NEAR(frame.intrinsics.fx, 1584.0 * kWidth / 1920, kTiny);
  EXPECT_NEAR(frame.intrinsics.cx, 948.0 * kWidth / 1920, kTiny);
  EXPECT_NEAR(frame.colour->intrinsics.fx, 1584.0 * 2 * kWidth / 1920, kTiny);
}

TEST_F(PhoneRecording, TurnsArkitsAxesIntoOurs) {
  const Pose pose = play(folder_.path()).frames.at(0).T_world_camera.value();
  EXPECT_TRUE((pose * Eigen::Vector3d(1, 2, 3)).isApprox(Eigen::Vector3d(8, 6, 6)));
}

TEST_F(PhoneRecording, HasNumbersAClockAndAnUprightWorld) {
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().world_up, UpAxis::kY);
  const Frame frame = play(**source).frames.at(0);
  EXPECT_EQ(frame.sequence, 6u);
  EXPECT_EQ(frame.timestamp_ns, 12'500'000'000);
}

TEST_F(PhoneRecording, DropsDepthOfLowConfidence) {
  write_grey8(folder_ / "conf_00006.png", 1);
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_depth"});
  AcquireConfig config;
  config.min_confidence = 1;
  EXPECT_EQ(play(folder_.path(), config).frames.size(), 1u);
}

TEST_F(PhoneRecording, DropsAFrameWhoseConfidenceHasAnotherSize) {
  write_grey8(folder_ / "conf_00006.png", 2, kWidth, kHeight - 1);
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"size_mismatch"});
}

TEST_F(PhoneRecording, DropsAFrameWhoseJsonIsCutAtAnyByte) {
  const std::string whole = json("1,0,0,7, 0,1,0,8, 0,0,1,9, 0,0,0,1");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_text(folder_ / "frame_00006.json", whole.substr(0, size));
    EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"unreadable"}) << "cut at " << size;
  }
}

TEST_F(PhoneRecording, DropsAFrameWhoseJsonHoldsOtherThings) {
  write_text(folder_ / "frame_00006.json", R"({"cameraPoseARFrame": "here", "intrinsics": [[1]], "time": []})");
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_intrinsics"});
}

TEST_F(PhoneRecording, DropsAFrameWithANonRigidPose) {
  write_text(folder_ / "frame_00006.json", json("1,0,0,7, 0,3,0,8, 0,0,1,9, 0,0,0,1"));
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"bad_pose"});
}

TEST_F(PhoneRecording, DropsAFrameWithoutItsJson) {
  write_depth(folder_ / "depth_00007.png", 3000);
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_intrinsics"});
}

}  // namespace
}  // namespace scanknit::test
