// Scenes of ARKitScenes, written here by the description of their format.
#include <gtest/gtest.h>

#include "damaged_file.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Reasons = std::vector<std::string>;

class Arkitscenes : public ::testing::Test {
 protected:
  void SetUp() override {
    add_frame("100.000", 1500);
    add_frame("100.050", 1600);
    add_frame("100.102", 1700);
    // A quarter turn about x, world to camera: the camera looks along the world's +y... and down is -z.
    write_text(scene() / "lowres_wide.traj",
               "100.0 1.5707963267948966 0 0 0 0 5\n100.102 1.5707963267948966 0 0 0 0 7\n");
  }
  [[nodiscard]] fs::path scene() const { return folder_ / "41069021/41069021_frames"; }
  void add_frame(const std::string& time, std::uint16_t depth) const {
    const std::string name = "41069021_" + time;
    write_depth(scene() / "lowres_depth" / (name + ".png"), depth);
    write_colour(scene() / "lowres_wide" / (name + ".png"), {9, 8, 7});
    write_grey8(scene() / "confidence" / (name + ".png"), 2);
    write_text(scene() / "lowres_wide_intrinsics" / (name + ".pincam"), "8 6 7.5 7.6 3.25 2.75");
  }

  TemporaryFolder folder_;
};

TEST_F(Arkitscenes, IsReadWithItsCamerasPosesAndTimes) {
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "arkitscenes");
  EXPECT_EQ((*source)->info().folder, scene());
  EXPECT_EQ((*source)->info().world_up, UpAxis::kZ);
  EXPECT_EQ((*source)->info().sensor->model, SensorModel::kPhoneLidar);
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 3u);
  const Frame& frame = p.frames[2];
  EXPECT_EQ(frame.timestamp_ns, 100'102'000'000);
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{8, 6, 7.5, 7.6, 3.25, 2.75}));
  EXPECT_EQ(frame.depth_m.at(7, 5), 1.7F);
  EXPECT_EQ(frame.colour.value().image.at(0, 0), (Rgb8{9, 8, 7}));
  EXPECT_EQ(frame.colour->intrinsics, frame.intrinsics);
  // p_camera = R p_world + (0, 0, 7), R = (x, -z, y): the camera is at y = -7 and looks along +y.
  EXPECT_TRUE(frame.T_world_camera->translation().isApprox(Eigen::Vector3d(0, -7, 0)));
  EXPECT_TRUE((*frame.T_world_camera * Eigen::Vector3d(0, 1, 2)).isApprox(Eigen::Vector3d(0, -5, -1)));
}

TEST_F(Arkitscenes, FindsPosesBetweenThoseThatAreRecorded) {
  const Frame frame = play(folder_.path()).frames.at(1);
  EXPECT_TRUE(frame.T_world_camera->translation().isApprox(Eigen::Vector3d(0, -5 - 2 * 50 / 102.0, 0), 1e-9))
      << "these are 102 ms apart";
}

TEST_F(Arkitscenes, TakesTheCameraAMillisecondOff) {
  fs::rename(scene() / "lowres_wide_intrinsics/41069021_100.050.pincam",
             scene() / "lowres_wide_intrinsics/41069021_100.049.pincam");
  EXPECT_EQ(play(folder_.path()).frames.size(), 3u);
  fs::rename(scene() / "lowres_wide_intrinsics/41069021_100.049.pincam",
             scene() / "lowres_wide_intrinsics/41069021_100.045.pincam");
  EXPECT_EQ(play(folder_.path()).reasons(), Reasons{"no_intrinsics"});
}

TEST_F(Arkitscenes, LeavesOutFramesThatCannotBeUsed) {
  write_text(scene() / "lowres_wide_intrinsics/41069021_100.000.pincam", "8 6 0 7.6 3.25 2.75");
  write_text(scene() / "lowres_wide.traj", "100.0 0 0 0 0 0 5\n100.050 0 0 0 nan 0 7\n");
  write_grey8(scene() / "confidence/41069021_100.102.png", 1);
  const Played p = play(folder_.path());
  EXPECT_EQ(p.reasons(), (Reasons{"no_intrinsics", "bad_pose", "no_depth"}));
  EXPECT_TRUE(contains(p.dropped[0].error.text(), "100.000.pincam: expected 'width height fx fy cx cy'"));
  EXPECT_TRUE(contains(p.dropped[1].error.text(), "lowres_wide.traj:2"));
}

TEST_F(Arkitscenes, SurvivesAnyDamage) {
  expect_survives_damage(folder_.path(), scene() / "lowres_wide.traj", 3);
  expect_survives_damage(folder_.path(), scene() / "lowres_wide_intrinsics/41069021_100.000.pincam", 3);
}

}  // namespace
}  // namespace scanknit::test
