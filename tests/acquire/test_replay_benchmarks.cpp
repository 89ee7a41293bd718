// The layouts of Replica (NICE-SLAM) and of BOP, written here by their descriptions.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "damaged_file.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Reasons = std::vector<std::string>;

class Replica : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* number : {"000000", "000001"}) {
      write_depth(room() / "results" / ("depth" + std::string(number) + ".png"), 13107);
      write_colour(room() / "results" / ("frame" + std::string(number) + ".png"), {1, 2, 3});
    }
    write_text(room() / "traj.txt", "1 0 0 1 0 1 0 2 0 0 1 3 0 0 0 1\n0 0 1 4 1 0 0 5 0 1 0 6 0 0 0 1\n");
    write_text(folder_ / "Replica/cam_params.json",
               R"({"camera": {"w": 8, "h": 6, "fx": 5, "fy": 5.5, "cx": 3.5, "cy": 2.5, "scale": 6553.5}})");
  }
  [[nodiscard]] fs::path room() const { return folder_ / "Replica/room0"; }

  TemporaryFolder folder_;
};

TEST_F(Replica, IsReadWithItsCameraAndPoses) {
  const auto source = open_recording(room(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "replica");
  EXPECT_EQ((*source)->info().world_up, UpAxis::kZ);
  EXPECT_EQ((*source)->info().depth_scale, 6553.5);
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[1].depth_m.at(0, 0), 2.0F);
  EXPECT_EQ(p.frames[1].intrinsics, (CameraIntrinsics{8, 6, 5, 5.5, 3.5, 2.5}));
  EXPECT_TRUE((*p.frames[1].T_world_camera * Eigen::Vector3d(0, 0, 2)).isApprox(Eigen::Vector3d(6, 5, 6)));
  EXPECT_EQ(p.frames[1].colour.value().image.at(0, 0), (Rgb8{1, 2, 3}));
  EXPECT_FALSE(p.frames[1].has_clock);
}

TEST_F(Replica, GivesEachNumberItsLineAlsoIfAPictureIsMissing) {
  fs::remove(room() / "results/depth000000.png");
  write_depth(room() / "results/depth000002.png", 13107);
  const Played p = play(room());
  EXPECT_EQ(p.reasons(), Reasons{"no_pose"}) << "number 2 has no line";
  ASSERT_EQ(p.frames.size(), 1u);
  EXPECT_EQ(p.frames[0].T_world_camera->translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(Replica, SaysWhatIsWrongWithItsCamera) {
  write_text(folder_ / "Replica/cam_params.json", R"({"camera": {"w": 8, "h": 6, "fx": 0}})");
  EXPECT_TRUE(contains(open_error(room()), "cam_params.json: expected {\"camera\""));
  fs::remove(folder_ / "Replica/cam_params.json");
  EXPECT_TRUE(contains(open_error(room()), "acquire.intrinsics=["));
}

TEST_F(Replica, SurvivesAnyDamage) {
  expect_survives_damage(room(), room() / "traj.txt", 2);
  expect_survives_damage(room(), folder_ / "Replica/cam_params.json", 2);
}

class Bop : public ::testing::Test {
 protected:
  void SetUp() override {
    const Json k = {5, 0, 3.5, 0, 5.5, 2.5, 0, 0, 1};
    // A quarter turn about z, world to camera; 1 m along its x axis.
    json_["3"] = {{"cam_K", k},
                  {"depth_scale", 0.1},
                  {"cam_R_w2c", {0, -1, 0, 1, 0, 0, 0, 0, 1}},
                  {"cam_t_w2c", {1000, 0, 500.5}}};
    json_["12"] = {{"cam_K", {6, 0, 3.25, 0, 6, 2.5, 0, 0, 1}},
                   {"depth_scale", 1},
                   {"cam_R_w2c", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                   {"cam_t_w2c", {0, 0, 0}}};
    for (const char* number : {"000003", "000012"}) {
      write_depth(folder_ / ("depth/" + std::string(number) + ".png"), 1500);
      write_colour(folder_ / ("rgb/" + std::string(number) + ".png"), {1, 2, 3});
    }
  }
  void write() const { write_text(folder_ / "scene_camera.json", json_.dump()); }
  [[nodiscard]] Played played(const AcquireConfig& config = {}) const {
    write();
    return play(folder_.path(), config);
  }

  TemporaryFolder folder_;
  Json json_ = Json::object();
};

TEST_F(Bop, IsReadWithEachImagesCameraUnitAndPose) {
  write();
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "bop") << "it would be Open3D's layout, too";
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  EXPECT_EQ(p.frames[0].sequence, 3u);
  EXPECT_EQ(p.frames[0].depth_m.at(0, 0), 0.15F) << "units of 0.1 mm";
  EXPECT_EQ(p.frames[1].depth_m.at(0, 0), 1.5F);
  EXPECT_EQ(p.frames[0].intrinsics, (CameraIntrinsics{8, 6, 5, 5.5, 3.5, 2.5}));
  EXPECT_EQ(p.frames[1].intrinsics, (CameraIntrinsics{8, 6, 6, 6, 3.25, 2.5}));
  EXPECT_TRUE(p.frames[0].T_world_camera->translation().isApprox(Eigen::Vector3d(0, 1, -0.5005)));
  EXPECT_TRUE(p.frames[0].colour);
}

TEST_F(Bop, WithoutPosesIsTracked) {
  for (auto& image : json_) {
    image.erase("cam_R_w2c");
    image.erase("cam_t_w2c");
  }
  write();
  const auto source = open_recording(folder_.path(), {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().poses, PoseMode::kTrack);
  EXPECT_EQ(play(**source).frames.size(), 2u);
}

TEST_F(Bop, LeavesOutImagesThatCannotBeUsed) {
  json_["3"].erase("cam_K");
  json_["12"]["depth_scale"] = 0;
  write_depth(folder_ / "depth/000013.png", 1500);
  json_["14"] = json_["12"];
  json_["14"]["depth_scale"] = 1;
  json_["14"]["cam_t_w2c"] = {1, 2};
  write_depth(folder_ / "depth/000014.png", 1500);
  const Played p = played();
  EXPECT_EQ(p.reasons(), (Reasons{"no_intrinsics", "unreadable", "no_intrinsics", "bad_pose"}));
  EXPECT_TRUE(contains(p.dropped[1].error.text(), "scene_camera.json: image 12: depth_scale"));
  EXPECT_TRUE(contains(p.dropped[2].error.text(), "names no image 13"));
}

TEST_F(Bop, SurvivesAnyOtherValueAndAnyDamage) {
  const std::vector<Json> values = {nullptr, true, -1, 0, 1e300, 1e-300, "x", Json::array(), Json::object()};
  const Json whole = json_;
  for (const auto& [key, unused] : whole["3"].items()) {
    for (const Json& value : values) {
      json_ = whole;
      json_["3"][key] = value;
      EXPECT_LE(played().frames.size(), 2u);
    }
  }
  json_ = whole;
  json_.erase("12");
  fs::remove(folder_ / "depth/000012.png");
  fs::remove_all(folder_ / "rgb");
  write();
  expect_survives_damage(folder_.path(), folder_ / "scene_camera.json", 1);
}

}  // namespace
}  // namespace scanknit::test
