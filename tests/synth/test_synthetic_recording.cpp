#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "synth/synthetic_source.h"
#include "synth/truth_files.h"
#include "synth/write_recording.h"
#include "tests/core/temporary_folder.h"
#include "tests/synth/test_synthetic_meshes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

SynthConfig small_config() {
  SynthConfig config;
  config.frames = 4;
  config.intrinsics = {80, 60, 65.625, 65.625, 39.5, 29.5};
  config.truth_points = 2000;
  config.min_views = 1;
  return config;
}

TEST(SyntheticRecording, HoldsTheDepthOfEveryPixelWithinHalfAUnit) {
  const test::TemporaryFolder folder;
  const auto scene = *make_scene("desk");
  const SynthConfig config = small_config();
  const auto summary = write_synthetic_recording(*scene, config, folder.path());
  ASSERT_TRUE(summary) << summary.error().text();
  EXPECT_EQ(summary->frames, 4u);
  const SyntheticScanner scanner(*scene, config);
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Mat raw = cv::imread(folder / ("depth/00000" + std::to_string(i) + ".png"), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(raw.type(), CV_16UC1);
    const Shot shot = scanner.shoot(i);
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 80; ++x) {
        EXPECT_NEAR(raw.at<std::uint16_t>(y, x) / config.depth_scale, static_cast<double>(shot.depth_m.at(x, y)),
                    0.501 / config.depth_scale);
      }
    }
  }
}

TEST(SyntheticRecording, HoldsTheColourExactlyAsPng) {
  const test::TemporaryFolder folder;
  const auto scene = *make_scene("sphere");
  ASSERT_TRUE(write_synthetic_recording(*scene, small_config(), folder.path()));
  const cv::Mat bgr = cv::imread(folder / "color/000001.png", cv::IMREAD_COLOR);
  const Shot shot = SyntheticScanner(*scene, small_config()).shoot(1);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const cv::Vec3b c = bgr.at<cv::Vec3b>(y, x);
      ASSERT_EQ((Rgb8{c[2], c[1], c[0]}), shot.exact.colour.at(x, y));
    }
  }
}

TEST(SyntheticRecording, HoldsThePosesToTheLastBit) {
  const test::TemporaryFolder folder;
  const auto scene = *make_scene("turntable");
  ASSERT_TRUE(write_synthetic_recording(*scene, small_config(), folder.path()));
  std::ifstream log(folder / "trajectory.log");
  for (const Pose& pose : camera_path(*scene, 4)) {
    int frame = 0;
    int ignored = 0;
    ASSERT_TRUE(log >> frame >> ignored >> ignored);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        double value = 0;
        ASSERT_TRUE(log >> value);
        EXPECT_EQ(value, pose.matrix()(row, column));
      }
    }
  }
}

TEST(SyntheticRecording, SaysItsCameraAndItsDepthScale) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_synthetic_recording(**make_scene("sphere"), small_config(), folder.path()));
  const auto json = nlohmann::json::parse(test::read_text(folder / "camera_intrinsic.json"));
  EXPECT_EQ(json["width"], 80);
  EXPECT_EQ(json["intrinsic_matrix"][0], 65.625);
  EXPECT_EQ(json["intrinsic_matrix"][7], 29.5);  // by columns: cy is the eighth
  EXPECT_EQ(json["depth_scale"], 10000);
}

TEST(SyntheticRecording, ReplacesAnOlderOneWhole) {
  const test::TemporaryFolder folder;
  SynthConfig config = small_config();
  ASSERT_TRUE(write_synthetic_recording(**make_scene("sphere"), config, folder.path()));
  config.frames = 2;
  ASSERT_TRUE(write_synthetic_recording(**make_scene("sphere"), config, folder.path()));
  EXPECT_TRUE(fs::exists(folder / "depth/000001.png"));
  EXPECT_FALSE(fs::exists(folder / "depth/000002.png"));
}

TEST(SyntheticRecording, LeavesARealRecordingAlone) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder / "depth");
  test::write_text(folder / "depth/000000.png", "precious");
  const auto summary = write_synthetic_recording(**make_scene("sphere"), small_config(), folder.path());
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kOutput);
  EXPECT_EQ(test::read_text(folder / "depth/000000.png"), "precious");
}

TEST(SyntheticRecording, StopsWhenAskedAndIsStillWhole) {
  const test::TemporaryFolder folder;
  std::stop_source stop;
  const auto summary = write_synthetic_recording(
      **make_scene("sphere"), small_config(), folder.path(),
      [&](std::size_t done, std::size_t) {
        if (done == 2) stop.request_stop();
      },
      stop.get_token());
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->was_stopped);
  EXPECT_EQ(summary->frames, 2u);
  EXPECT_TRUE(read_truth(folder.path()));
}

TEST(SyntheticRecording, ReportsAFolderThatCannotBeMade) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "file", "");
  const auto summary = write_synthetic_recording(**make_scene("sphere"), small_config(), folder / "file/inside");
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error().code, ErrorCode::kOutput);
}

TEST(SynthConfig, RefusesValuesWithoutMeaning) {
  const auto code_of = [](auto change) {
    SynthConfig config = small_config();
    change(config);
    const auto valid = validate(config);
    return valid ? std::string() : valid.error().message.substr(0, valid.error().message.find(':'));
  };
  EXPECT_EQ(code_of([](SynthConfig&) {}), "");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.frames = -1; }), "frames");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.depth_scale = 0; }), "depth_scale");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.depth_scale = std::nan(""); }), "depth_scale");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.intrinsics.fx = 0; }), "intrinsics");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.intrinsics.width = 2'000'000'000; }), "width x height");
  EXPECT_EQ(code_of([](SynthConfig& c) { c.stills = 0; }), "stills");
}

class TruthFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto scene = *make_mesh_scene(test::icosphere(1, 2), 0.2);
    ASSERT_TRUE(write_synthetic_recording(*scene, small_config(), folder_.path()));
  }
  test::TemporaryFolder folder_;
};

TEST_F(TruthFiles, RebuildTheMeshSceneToTheLastBit) {
  const auto truth = read_truth(folder_.path());
  ASSERT_TRUE(truth) << truth.error().text();
  const auto original = *make_mesh_scene(test::icosphere(1, 2), 0.2);
  EXPECT_EQ(truth->scene->mesh()->positions_m, original->mesh()->positions_m);
  EXPECT_EQ(truth->scene->mesh()->triangles, original->mesh()->triangles);
}

TEST_F(TruthFiles, HoldThePointsThatWereSeen) {
  const auto truth = read_truth(folder_.path());
  ASSERT_TRUE(truth);
  ASSERT_GT(truth->visible.size(), 500u);
  for (const TruthPoint& point : truth->visible) {
    EXPECT_GE(point.views, 1u);
    EXPECT_NEAR(truth->scene->distance(point.position_m.cast<double>()), 0, 1e-6);
  }
}

TEST_F(TruthFiles, AreRefusedWhenCutShortAnywhere) {
  for (const char* name : {kVisiblePointsFile, kGroundTruthMeshFile, kGroundTruthFile}) {
    const std::string whole = test::read_text(folder_ / name);
    // Every byte of the header, then strides through the body.
    for (std::size_t size = 0; size + 3 < whole.size(); size += size < 300 ? 1 : 997) {
      test::write_text(folder_ / name, whole.substr(0, size));
      ASSERT_FALSE(read_truth(folder_.path())) << name << " cut to " << size;
    }
    test::write_text(folder_ / name, whole);
  }
  EXPECT_TRUE(read_truth(folder_.path()));
}

TEST_F(TruthFiles, AreRefusedWhenACountIsALie) {
  std::string text = test::read_text(folder_ / kVisiblePointsFile);
  const std::size_t at = text.find("vertex ") + 7;
  text.replace(at, text.find('\n', at) - at, "18446744073709551615");
  test::write_text(folder_ / kVisiblePointsFile, text);
  const auto truth = read_truth(folder_.path());
  ASSERT_FALSE(truth);
  EXPECT_EQ(truth.error().code, ErrorCode::kInput);
}

TEST_F(TruthFiles, AreRefusedWhenTheSceneIsNoLongerTheOneThatWasScanned) {
  test::write_text(folder_ / kGroundTruthFile, R"({"scene": "turntable"})");  // the points are on a sphere
  const auto truth = read_truth(folder_.path());
  ASSERT_FALSE(truth);
  EXPECT_NE(truth.error().message.find("has changed"), std::string::npos);
}

TEST_F(TruthFiles, AreRefusedForASceneNobodyKnows) {
  test::write_text(folder_ / kGroundTruthFile, R"({"scene": "atlantis"})");
  const auto truth = read_truth(folder_.path());
  ASSERT_FALSE(truth);
  EXPECT_EQ(truth.error().code, ErrorCode::kInput);
}

}  // namespace
}  // namespace scanknit
