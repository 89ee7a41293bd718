// transforms.json of nerfstudio and instant-ngp: axes, units, cameras, and what cannot be held.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "acquire/convert/convert_recording.h"
#include "acquire/convert/picture_files.h"
#include "acquire/replay/undistort.h"
#include "test_replay_support.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Reasons = std::vector<std::string>;

// In OpenGL's axes: at (1, 2, 3), a camera that looks along the world's +y with the world's z up.
const Json kLooksAlongY = {{1, 0, 0, 1}, {0, 0, -1, 2}, {0, 1, 0, 3}, {0, 0, 0, 1}};

class Nerfstudio : public ::testing::Test {
 protected:
  void SetUp() override {
    json_ = {{"camera_model", "OPENCV"},
             {"w", kWidth},
             {"h", kHeight},
             {"fl_x", 100},
             {"fl_y", 110},
             {"cx", 4.0},
             {"cy", 3.0},
             {"k1", 0},
             {"frames", Json::array()}};
    for (const char* number : {"1", "2"}) {
      write_depth(folder_ / ("depth/" + std::string(number) + ".png"), 1500);
      write_colour(folder_ / ("images/" + std::string(number) + ".png"), {10, 20, 30});
      add_frame(number);
    }
  }
  void add_frame(const std::string& number) {
    json_["frames"].push_back({{"file_path", "images/" + number + ".png"},
                               {"depth_file_path", "depth/" + number + ".png"},
                               {"transform_matrix", kLooksAlongY}});
  }
  void write() const { write_text(folder_ / "transforms.json", json_.dump()); }
  [[nodiscard]] Played played(const AcquireConfig& config = {}) const {
    write();
    return play(folder_.path(), config);
  }
  [[nodiscard]] std::string refused() const {
    write();
    return open_error(folder_.path());
  }

  TemporaryFolder folder_;
  Json json_;
};

TEST_F(Nerfstudio, IsReadWithItsCameraAxesAndMillimetres) {
  const Played p = played();
  ASSERT_EQ(p.frames.size(), 2u);
  const Frame& frame = p.frames[0];
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{8, 6, 100, 110, 3.5, 2.5})) << "pixels counted from a corner";
  EXPECT_EQ(frame.depth_m.at(0, 0), 1.5F);
  EXPECT_EQ(frame.colour.value().image.at(0, 0), (Rgb8{10, 20, 30}));
  EXPECT_EQ(frame.colour->intrinsics, frame.intrinsics);
  const Eigen::Vector3d p_world = *frame.T_world_camera * Eigen::Vector3d(0.1, 0.2, 1.5);
  EXPECT_TRUE(p_world.isApprox(Eigen::Vector3d(1.1, 3.5, 2.8))) << "right is +x, down is -z, forward is +y";
  EXPECT_FALSE(frame.has_clock);
}

TEST_F(Nerfstudio, IsStraightenedOnceByTheColourCameraThatIsStated) {
  json_["k1"] = 0.3;
  ScannerCamera camera;
  camera.colour = CameraModel{{kWidth, kHeight, 90, 95, 3.4, 2.6}, {0.1, 0.05, 0, 0, 0}};
  AcquireConfig config;
  config.camera = std::make_shared<const ScannerCamera>(camera);
  ColourImage picture(kWidth, kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i)
    picture.pixels()[static_cast<std::size_t>(i)].r = static_cast<std::uint8_t>(5 * i);
  ASSERT_TRUE(write_colour_png(picture, folder_ / "images/1.png"));
  const Played p = played(config);
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].intrinsics, (CameraIntrinsics{8, 6, 100, 110, 3.5, 2.5}));
  EXPECT_EQ(p.frames[0].colour.value().intrinsics, camera.colour->intrinsics);
  EXPECT_EQ(p.frames[0].colour->image, undistort(picture, camera.colour->intrinsics, camera.colour->distortion));
}

TEST_F(Nerfstudio, DescribesItself) {
  write();
  const auto source = open_recording(folder_ / "transforms.json", {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "nerfstudio");
  EXPECT_EQ((*source)->info().frames_with_pose, 2u);
  EXPECT_EQ((*source)->info().depth_scale, 1000);
  EXPECT_EQ((*source)->info().world_up, UpAxis::kZ);
}

TEST_F(Nerfstudio, KnowsTheUnitsOfBothPrograms) {
  json_["depth_unit_scale_factor"] = 0.0002;
  EXPECT_EQ(played().frames.at(0).depth_m.at(0, 0), 0.3F);
  json_.erase("depth_unit_scale_factor");
  json_["integer_depth_scale"] = 0.0001;
  EXPECT_EQ(played().frames.at(0).depth_m.at(0, 0), 0.15F);
  json_["integer_depth_scale"] = 0;
  EXPECT_TRUE(contains(refused(), "integer_depth_scale: expected metres of one raw unit"));
}

TEST_F(Nerfstudio, TakesInstantNgpsKeys) {
  json_["frames"].erase(1);
  for (const char* key : {"fl_x", "fl_y", "cx", "cy"}) json_.erase(key);
  json_["camera_angle_x"] = 2 * std::atan(4.0 / 100);
  json_["frames"][0]["depth_path"] = "depth/1";
  json_["frames"][0]["file_path"] = "./images/1";
  json_["frames"][0].erase("depth_file_path");
  const Played p = played();
  ASSERT_EQ(p.frames.size(), 1u);
  EXPECT_NEAR(p.frames[0].intrinsics.fx, 100, 1e-9);
  EXPECT_EQ(p.frames[0].intrinsics.fy, p.frames[0].intrinsics.fx);
  EXPECT_EQ(p.frames[0].intrinsics.cx, 3.5);
  EXPECT_TRUE(p.frames[0].colour);
}

TEST_F(Nerfstudio, GivesEachFrameItsOwnCamera) {
  json_["frames"][1]["fl_x"] = 90;
  json_["frames"][1]["cx"] = 5;
  const Played p = played();
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].intrinsics.fx, 100);
  EXPECT_EQ(p.frames[1].intrinsics, (CameraIntrinsics{8, 6, 90, 110, 4.5, 2.5}));
}

TEST_F(Nerfstudio, ScalesTheCameraToDepthOfAnotherSize) {
  write_colour(folder_ / "images/1.png", {1, 2, 3}, 2 * kWidth, 2 * kHeight);
  json_["frames"].erase(1);
  json_.update({{"w", 2 * kWidth}, {"h", 2 * kHeight}, {"fl_x", 200}, {"fl_y", 220}, {"cx", 8}, {"cy", 6}});
  const Frame frame = played().frames.at(0);
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{8, 6, 100, 110, 3.5, 2.5}));
  EXPECT_EQ(frame.colour->intrinsics, (CameraIntrinsics{16, 12, 200, 220, 7.5, 5.5}));
}

TEST_F(Nerfstudio, StraightensBothPictures) {
  cv::Mat depth(kHeight, kWidth, CV_16UC1);
  std::uint16_t value = 1000;
  for (auto pixel = depth.begin<std::uint16_t>(); pixel != depth.end<std::uint16_t>(); ++pixel) *pixel = value++;
  ASSERT_TRUE(cv::imwrite((folder_ / "depth/1.png").string(), depth));
  const DepthImage bent = played().frames.at(0).depth_m;
  json_.update({{"k1", 150.0}, {"k2", 2.0}, {"p1", 0.5}, {"p2", -0.25}});
  const Frame frame = played().frames.at(0);
  EXPECT_EQ(frame.depth_m, undistort(bent, frame.intrinsics, {150.0, 2.0, 0.5, -0.25, 0}));
  EXPECT_NE(frame.depth_m, bent);
  EXPECT_EQ(frame.colour->encoded, nullptr) << "the file shows the bent picture";
}

TEST_F(Nerfstudio, UndoesWhatItsWriterDidToTheWorld) {
  json_["applied_transform"] = {{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 5}};  // a world whose y points down
  json_["applied_scale"] = 2;
  write();
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().world_up, UpAxis::kMinusY);
  const Frame frame = play(**source).frames.at(0);
  // Half of (1, 2, 3), less (0, 0, 5), turned back: file (x, y, z) is (x, -z, y) of the world.
  EXPECT_TRUE(frame.T_world_camera->translation().isApprox(Eigen::Vector3d(0.5, 3.5, 1)));
  EXPECT_TRUE((frame.T_world_camera->linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d::UnitZ()));
}

TEST_F(Nerfstudio, RefusesAWorldThatIsNoTurn) {
  json_["applied_transform"] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}};
  EXPECT_TRUE(contains(refused(), "applied_transform: the pose is not rigid: it mirrors"));
  json_.erase("applied_transform");
  json_["applied_scale"] = "much";
  EXPECT_TRUE(contains(refused(), "applied_scale: expected a number greater than 0"));
}

TEST_F(Nerfstudio, RefusesALensThatCannotBeHeldAndSaysWhatToDo) {
  json_["camera_model"] = "OPENCV_FISHEYE";
  EXPECT_TRUE(contains(refused(), "camera_model: 'OPENCV_FISHEYE' is not read")) << refused();
  EXPECT_TRUE(contains(refused(), "undistort")) << refused();
  json_["camera_model"] = "OPENCV";
  json_["k4"] = 0.1;
  EXPECT_TRUE(contains(refused(), "k4"));
  json_.erase("k4");
  json_.erase("w");
  EXPECT_TRUE(contains(refused(), "w, h: expected the size"));
  AcquireConfig config;
  config.intrinsics = CameraModel{{8, 6, 100, 100, 3.5, 2.5}, {}};
  EXPECT_EQ(played(config).frames.size(), 2u) << "the configuration's camera stands for the file's";
}

TEST_F(Nerfstudio, DropsOneFrameWithABadCameraOrPose) {
  add_frame("1");
  add_frame("2");
  json_["frames"][0]["fl_x"] = 0;
  json_["frames"][0]["fl_y"] = 0;
  json_["frames"][1]["transform_matrix"] = {{1, 2}, {3}};
  json_["frames"][2].erase("transform_matrix");
  const Played p = played();
  EXPECT_EQ(p.reasons(), (Reasons{"no_intrinsics", "no_pose", "bad_pose"})) << "sorted by name";
  EXPECT_EQ(p.frames.size(), 1u);
}

TEST_F(Nerfstudio, SortsFramesByName) {
  std::swap(json_["frames"][0], json_["frames"][1]);
  write_depth(folder_ / "depth/2.png", 2000);
  const Played p = played();
  EXPECT_EQ(p.frames.at(0).depth_m.at(0, 0), 1.5F);
  EXPECT_EQ(p.frames.at(1).depth_m.at(0, 0), 2.0F);
}

TEST_F(Nerfstudio, LeavesOutFramesWithoutDepthAndSaysSo) {
  json_["frames"][1].erase("depth_file_path");
  write();
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source);
  EXPECT_EQ((*source)->info().frames, 1u);
  EXPECT_EQ((*source)->info().warnings, Reasons{"1 frames name no depth picture and are left out"});
  json_["frames"][0].erase("depth_file_path");
  EXPECT_TRUE(contains(refused(), "nerfstudio: transforms.json whose frames have a depth_file_path"));
}

TEST_F(Nerfstudio, NeverLeavesItsFolder) {
  json_["frames"][0]["depth_file_path"] = "../depth/1.png";
  json_["frames"][1]["file_path"] = "/etc/passwd";
  EXPECT_EQ(played().reasons(), (Reasons{"unsafe_path", "unsafe_path"}));
}

TEST_F(Nerfstudio, CutAtAnyByteIsNoRecording) {
  json_["frames"].erase(1);
  write();
  const auto whole = bytes_of(folder_ / "transforms.json");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_bytes(folder_ / "transforms.json", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_TRUE(contains(open_error(folder_.path()), "no recording of a known layout")) << size;
  }
}

TEST_F(Nerfstudio, SurvivesAnyOtherValue) {
  const Json whole = json_;
  const std::vector<Json> values = {nullptr, true, -1, 0, 1e300, "x", Json::array(), Json::object(), {{1, 2}}};
  const auto plays = [&] {
    write();
    const auto source = open_recording(folder_.path(), {});
    if (source) (void)play(**source);
  };
  json_["applied_transform"] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  const Json all = json_;
  for (const auto& [key, unused] : all.items()) {
    for (const Json& value : values) {
      json_ = all;
      json_[key] = value;
      plays();
    }
  }
  for (const auto& [key, unused] : whole["frames"][0].items()) {
    for (const Json& value : values) {
      json_ = whole;
      json_["frames"][0][key] = value;
      plays();
    }
  }
}

TEST(NerfstudioTarget, LeavesOutFramesWithoutAPose) {
  const TemporaryFolder folder;
  write_seven_scenes(folder / "in", 3);
  fs::remove(folder / ("in/" + seven_scenes_name(1, "pose.txt")));
  AcquireConfig config;
  config.poses = PoseMode::kTrack;
  auto source = open_recording(folder / "in", config);
  const auto summary = convert_recording(**source, ConvertTarget::kNerfstudio, folder / "out");
  ASSERT_TRUE(summary) << summary.error().text();
  EXPECT_EQ(summary->frames, 2u);
  EXPECT_EQ(summary->dropped, 1u);
  EXPECT_EQ(play(folder / "out").frames.size(), 2u);
  for (const int i : {0, 2}) fs::remove(folder / ("in/" + seven_scenes_name(i, "pose.txt")));
  auto without = open_recording(folder / "in", config);
  const auto refused = convert_recording(**without, ConvertTarget::kNerfstudio, folder / "none");
  ASSERT_FALSE(refused);
  EXPECT_TRUE(contains(refused.error().text(), "has no pose"));
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST(NerfstudioTarget, StandsUprightAndComesBackAsItWas) {
  const TemporaryFolder folder;
  write_seven_scenes(folder / "in", 1);
  write_text(folder / ("in/" + seven_scenes_name(0, "pose.txt")), "0 0 1 4\n1 0 0 5\n0 1 0 6\n0 0 0 1\n");
  auto source = open_recording(folder / "in", {});
  ASSERT_TRUE(convert_recording(**source, ConvertTarget::kNerfstudio, folder / "out"));
  const auto bytes = bytes_of(folder / "out/transforms.json");
  std::string text;
  for (const std::byte b : bytes) text += static_cast<char>(b);
  const Json json = Json::parse(text);
  // The recording's y points down: its down is the file's -z. (4, 5, 6) is 5 m below the origin.
  EXPECT_EQ(json["frames"][0]["transform_matrix"][2][3], -5.0);
  const auto back = open_recording(folder / "out", {});
  EXPECT_EQ((*back)->info().world_up, UpAxis::kMinusY);
  constexpr double kRounding = 1e-14;  // the nearest rotation is found again
  EXPECT_TRUE(
      play(**back).frames.at(0).T_world_camera->isApprox(*play(folder / "in").frames.at(0).T_world_camera, kRounding));
}

}  // namespace
}  // namespace scanknit::test
