// Recordings of Stray Scanner, written here by the description of their format.
#include <gtest/gtest.h>

#include "damaged_file.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

constexpr const char* kHeader = "timestamp, frame, x, y, z, qx, qy, qz, qw";

class StrayScanner : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 2; ++i) {
      write_depth(folder_ / ("depth/" + number(i) + ".png"), static_cast<std::uint16_t>(1500 + i));
      write_grey8(folder_ / ("confidence/" + number(i) + ".png"), 2);
    }
    write_text(folder_ / "camera_matrix.csv", "1600.0, 0.0, 959.5\n0.0, 1610.0, 719.5\n0.0, 0.0, 1.0");
    write_text(folder_ / "odometry.csv", std::string(kHeader) +
                                             "\n10.5, 000000, 1, 2, 3, 0, 0, 0, 1\n"
                                             "10.533333333, 000001, 1, 2, 4, 0, 0.70710678, 0, 0.70710678\n");
    write_text(folder_ / "rgb.mp4", "a video");
  }
  static std::string number(int i) { return "00000" + std::to_string(i); }

  TemporaryFolder folder_;
};

TEST_F(StrayScanner, IsReadWithItsCameraPosesAndTimes) {
  const Played p = play(folder_.path());
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  const Frame& frame = p.frames[1];
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.501F);
  EXPECT_EQ(frame.timestamp_ns, 10'533'333'333);
  EXPECT_EQ(frame.sequence, 1u);
  // 1920 x 1440 pixels become 8 x 6; the middle stays the middle.
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{kWidth, kHeight, 1600.0 / 240, 1610.0 / 240, 3.5, 2.5}));
  const Eigen::Vector3d p_world = *frame.T_world_camera * Eigen::Vector3d(0, 0, 1.5);
  EXPECT_TRUE(p_world.isApprox(Eigen::Vector3d(2.5, 2, 4), 1e-6)) << "a quarter turn about y: it looks along +x";
  EXPECT_FALSE(frame.colour);
}

TEST_F(StrayScanner, DescribesItselfAndSaysHowToGetColour) {
  const auto source = open_recording(folder_ / "depth/000001.png", {});
  ASSERT_TRUE(source) << source.error().text();
  const RecordingInfo& info = (*source)->info();
  EXPECT_EQ(info.format, "stray-scanner");
  EXPECT_EQ(info.world_up, UpAxis::kY);
  ASSERT_TRUE(info.sensor);
  EXPECT_EQ(info.sensor->model, SensorModel::kPhoneLidar);
  ASSERT_EQ(info.warnings.size(), 1u);
  EXPECT_TRUE(contains(info.warnings[0], "ffmpeg -i rgb.mp4")) << info.warnings[0];
}

TEST_F(StrayScanner, TakesPicturesOfItsVideoAlsoIfCountedFromOne) {
  for (const int first : {0, 1}) {
    fs::remove_all(folder_ / "rgb");
    for (int i = 0; i < 2; ++i) {
      const Rgb8 colour{static_cast<std::uint8_t>(100 * (i + 1)), 0, 0};
      write_colour(folder_ / ("rgb/" + number(first + i) + ".png"), colour, 4 * kWidth, 4 * kHeight);
    }
    const auto source = open_recording(folder_.path(), {});
    ASSERT_TRUE(source) << source.error().text();
    EXPECT_EQ((*source)->info().format, "stray-scanner") << "it would be Open3D's layout, too";
    EXPECT_TRUE((*source)->info().warnings.empty());
    const Played p = play(**source);
    ASSERT_EQ(p.frames.size(), 2u);
    EXPECT_EQ(p.frames[0].colour.value().image.at(0, 0).r, 100);
    EXPECT_EQ(p.frames[1].colour.value().image.at(0, 0).r, 200);
    EXPECT_EQ(p.frames[1].colour->intrinsics, (CameraIntrinsics{32, 24, 1600.0 / 60, 1610.0 / 60, 15.5, 11.5}));
  }
}

TEST_F(StrayScanner, GivesEachFrameItsOwnCamera) {
  write_text(folder_ / "odometry.csv", std::string(kHeader) +
                                           ", fx, fy, cx, cy, distortion_center_x, distortion_center_y\n"
                                           "1, 000000, 0, 0, 0, 0, 0, 0, 1, 1200, 1440, 959.5, 719.5, 960, 720\n"
                                           "2, 000001, 0, 0, 0, 0, 0, 0, 1, 1440, x, 959.5, 719.5, 960, 720\n");
  const Played p = play(folder_.path());
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].intrinsics, (CameraIntrinsics{kWidth, kHeight, 5, 6, 3.5, 2.5}));
  EXPECT_EQ(p.frames[1].intrinsics.fx, 1600.0 / 240) << "that of camera_matrix.csv";
}

TEST_F(StrayScanner, LeavesOutDepthOfLittleConfidence) {
  write_grey8(folder_ / "confidence/000000.png", 1);
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_depth"});
  AcquireConfig config;
  config.min_confidence = 1;
  EXPECT_EQ(play(folder_.path(), config).frames.size(), 2u);
}

TEST_F(StrayScanner, DropsFramesWithoutDepthOrPose) {
  write_text(folder_ / "odometry.csv",
             std::string(kHeader) + "\n1, 000001, 0, 0, 0, 0, 0, 0, 3\n2, 000007, 0, 0, 0, 0, 0, 0, 1\n3\n");
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_TRUE(contains((*source)->info().warnings.at(0), "1 lines of odometry.csv name no frame"));
  const Played p = play(**source);
  EXPECT_EQ(p.reasons(), (Reasons{"no_pose", "bad_pose", "missing_file"}));
  EXPECT_TRUE(contains(p.dropped[1].error.text(), "odometry.csv:2"));
  EXPECT_TRUE(contains(p.dropped[2].error.text(), "depth/000007.png"));
}

TEST_F(StrayScanner, RefusesAVideoOfAnotherSizeUnlessTheCameraIsStated) {
  write_text(folder_ / "camera_matrix.csv", "1600, 0, 1919.5\n0, 1600, 1079.5\n0, 0, 1");
  EXPECT_TRUE(contains(open_error(folder_.path()), "states no camera of pictures of 1920 x 1440"));
  AcquireConfig config;
  config.intrinsics = CameraModel{{0, 0, 7, 7, 3.5, 2.5}, {}};
  EXPECT_EQ(play(folder_.path(), config).frames.at(0).intrinsics.fx, 7);
}

TEST_F(StrayScanner, RefusesATableWithoutItsHeader) {
  write_text(folder_ / "odometry.csv", "1, 2, 3, 0, 0, 0, 1\n");
  EXPECT_TRUE(contains(open_error(folder_.path()), "expected the first line 'timestamp, frame, x"));
}

TEST_F(StrayScanner, SurvivesAnyDamage) {
  expect_survives_damage(folder_.path(), folder_ / "odometry.csv", 2);
  expect_survives_damage(folder_.path(), folder_ / "camera_matrix.csv", 2);
}

}  // namespace
}  // namespace scanknit::test
