// Polycam's raw data, written here by the description of its format.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "damaged_file.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Reasons = std::vector<std::string>;

class Polycam : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"2000000", "2500000"}) {
      write_depth(keyframes() / "depth" / (std::string(name) + ".png"), 1500);
      write_grey8(keyframes() / "confidence" / (std::string(name) + ".png"), 255);
      write_colour(keyframes() / "images" / (std::string(name) + ".png"), {1, 2, 3}, 2 * kWidth, 2 * kHeight);
      write_camera("cameras", name, 0);
    }
  }
  [[nodiscard]] fs::path keyframes() const { return folder_ / "capture/keyframes"; }
  /// ARKit's axes: at (x, 0, 0), level, it looks along -z.
  static Json camera(double x) {
    Json json = {{"fx", 14}, {"fy", 15}, {"cx", 7.5}, {"cy", 5.5}, {"width", 16}, {"height", 12}, {"blur_score", 80.5}};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        json["t_" + std::to_string(row) + std::to_string(column)] = row == column ? 1 : 0;
      }
    }
    json["t_03"] = x;
    return json;
  }
  void write_camera(const char* set, const std::string& name, double x) const {
    write_text(keyframes() / set / (name + ".json"), camera(x).dump());
  }

  TemporaryFolder folder_;
};

TEST_F(Polycam, IsReadWithItsCamerasPosesAndTimes) {
  const auto source = open_recording(folder_ / "capture", {});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->info().format, "polycam");
  EXPECT_EQ((*source)->info().world_up, UpAxis::kY);
  EXPECT_EQ((*source)->info().sensor->model, SensorModel::kPhoneLidar);
  const Played p = play(**source);
  EXPECT_TRUE(p.dropped.empty());
  ASSERT_EQ(p.frames.size(), 2u);
  const Frame& frame = p.frames[1];
  EXPECT_EQ(frame.timestamp_ns, 2'500'000'000);
  EXPECT_EQ(frame.depth_m.at(3, 3), 1.5F);
  EXPECT_EQ(frame.intrinsics, (CameraIntrinsics{8, 6, 7, 7.5, 3.5, 2.5}));
  EXPECT_EQ(frame.colour.value().intrinsics, (CameraIntrinsics{16, 12, 14, 15, 7.5, 5.5}));
  const Eigen::Vector3d p_world = *frame.T_world_camera * Eigen::Vector3d(0.25, 0.5, 2);
  EXPECT_TRUE(p_world.isApprox(Eigen::Vector3d(0.25, -0.5, -2))) << "down is -y, forward is -z";
}

TEST_F(Polycam, TakesTheCorrectedCamerasAndNeverMixesThem) {
  write_camera("corrected_cameras", "2500000", 4);
  write_colour(keyframes() / "corrected_images/2500000.png", {200, 2, 3}, 2 * kWidth, 2 * kHeight);
  const Played p = play(folder_ / "capture");
  EXPECT_EQ(p.reasons(), Reasons{"no_pose"}) << "the first frame has no corrected camera";
  ASSERT_EQ(p.frames.size(), 1u);
  EXPECT_EQ(p.frames[0].T_world_camera->translation(), Eigen::Vector3d(4, 0, 0));
  EXPECT_EQ(p.frames[0].colour.value().image.at(0, 0).r, 200);
}

TEST_F(Polycam, KnowsItsThreeLevelsOfConfidence) {
  write_grey8(keyframes() / "confidence/2000000.png", 127);
  write_grey8(keyframes() / "confidence/2500000.png", 0);
  const auto frames_at = [&](int confidence) {
    AcquireConfig config;
    config.min_confidence = confidence;
    return play(folder_ / "capture", config).frames.size();
  };
  EXPECT_EQ(frames_at(0), 2u);
  EXPECT_EQ(frames_at(1), 1u);
  EXPECT_EQ(frames_at(2), 0u);
}

TEST_F(Polycam, LeavesOutFramesThatCannotBeUsed) {
  Json json = camera(0);
  json["t_11"] = "one";
  write_text(keyframes() / "cameras/2000000.json", json.dump());
  json = camera(0);
  json.erase("width");
  write_text(keyframes() / "cameras/2500000.json", json.dump());
  const Played p = play(folder_ / "capture");
  EXPECT_EQ(p.reasons(), (Reasons{"bad_pose", "no_intrinsics"}));
  EXPECT_TRUE(contains(p.dropped[0].error.text(), "2000000.json: t_11: expected a number"));
}

TEST_F(Polycam, SurvivesAnyOtherValueAndAnyDamage) {
  const std::vector<Json> values = {nullptr, true, -1, 0, 1e300, "x", Json::array(), Json::object()};
  const Json whole = camera(0);
  for (const auto& [key, unused] : whole.items()) {
    for (const Json& value : values) {
      Json json = whole;
      json[key] = value;
      write_text(keyframes() / "cameras/2000000.json", json.dump());
      EXPECT_LE(play(folder_ / "capture").frames.size(), 2u);
    }
  }
  write_camera("cameras", "2000000", 0);
  fs::remove_all(keyframes() / "images");
  expect_survives_damage(folder_ / "capture", keyframes() / "cameras/2000000.json", 2);
}

}  // namespace
}  // namespace scanknit::test
