// acquire.camera: what CAMERA.yaml states of a scanner, from the file to the mesh.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <string_view>

#include "tests/app/scan.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kSameLens = "{width: 160, height: 120, fx: 131.25, fy: 131.25, cx: 79.5, cy: 59.5}\n";

/// The same number everywhere in the picture.
std::string field(double value) {
  std::string text = "[" + std::to_string(value);
  for (int i = 1; i < 16; ++i) text += ", " + std::to_string(value);
  return text + "]\n";
}

class ScannerCameraFile : public ::testing::Test {
 protected:
  [[nodiscard]] Outcome run_with(const std::string& camera, const std::vector<std::string>& more = {}) const {
    std::ofstream(scan_ / "CAMERA.yaml") << camera;
    std::vector<std::string> arguments = {"--set", "acquire.camera=" + (scan_ / "CAMERA.yaml").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scan_.run(arguments);
  }
  [[nodiscard]] std::string mesh() const { return read_text(scan_.output() / "model.ply"); }
  /// The mean distance of the mesh from `reference`.
  [[nodiscard]] double deviation_mm(const std::string& reference) const {
    std::ofstream(scan_ / "reference.ply", std::ios::binary) << reference;
    const Outcome outcome = scanknit_command(
        {"distance", (scan_.output() / "model.ply").string(), (scan_ / "reference.ply").string(), "--json"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return 1000 * Json::parse(outcome.out).at("vertices").at("mean_absolute_m").get<double>();
  }
  void expect_refused(const std::string& camera, int exit_code, std::string_view said) const {
    const Outcome outcome = run_with(camera);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(scan_.output() / "model.ply"));
  }

  Scan scan_{{.frames = 12, .width = 160, .height = 120}};
};

TEST_F(ScannerCameraFile, ThatSaysWhatTheRecordingSaysChangesNothing) {
  ASSERT_EQ(scan_.run().exit_code, 0);
  const std::string without = mesh();
  const Outcome outcome = run_with(std::string("colour: ") + kSameLens + "depth: " + kSameLens);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(mesh(), without);
}

TEST_F(ScannerCameraFile, TakesTheErrorOutOfDepth) {
  ASSERT_EQ(scan_.run().exit_code, 0);
  const std::string right = mesh();
  // Depth becomes 3 % too small.
  const fs::path stated = scan_.recording() / "camera_intrinsic.json";
  Json camera = Json::parse(read_text(stated));
  camera["depth_scale"] = camera["depth_scale"].get<double>() * 1.03;
  std::ofstream(stated) << camera.dump();
  ASSERT_EQ(scan_.run().exit_code, 0);
  EXPECT_GT(deviation_mm(right), 5);

  const std::string bias = "depth_bias:\n  columns: 4\n  rows: 4\n  scale: " + field(1 / 1.03 - 1);
  const Outcome outcome = run_with(std::string("depth: ") + kSameLens + bias + "  shift_per_m: " + field(0));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(deviation_mm(right), 0.05);
}

TEST_F(ScannerCameraFile, ForAnotherSizeDropsEveryPicture) {
  expect_refused("depth: {width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5}\n", 4, "size_mismatch");
}

TEST_F(ScannerCameraFile, ThatIsWrongIsRefusedWithItsLine) {
  expect_refused("depth: {width: 160, height: 120, fx: wide, fy: 131, cx: 79.5, cy: 59.5}\n", 3, "CAMERA.yaml:1:");
  expect_refused(
      std::string("depth: ") + kSameLens + "depth_bias: {columns: 4, rows: 4, scale: [0], shift_per_m: [0]}\n", 3,
      "CAMERA.yaml:2:");
  expect_refused(std::string("depth: ") + kSameLens + "colours: red\n", 3, "CAMERA.yaml:2:");
  expect_refused("serial: 7\n", 3, "CAMERA.yaml");
  expect_refused(std::string("depth: ") + kSameLens + "T_colour_depth: [0, 0, 0, 0, 0, 0, 0]\n", 3, "CAMERA.yaml:2:");
}

TEST_F(ScannerCameraFile, IsNotGivenBesideALensAlone) {
  std::ofstream(scan_ / "lens.yaml") << "depth: " << kSameLens;
  const Outcome outcome =
      run_with(std::string("depth: ") + kSameLens, {"--set", "acquire.intrinsics=" + (scan_ / "lens.yaml").string()});
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_NE(outcome.err.find("acquire.intrinsics"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace scanknit
