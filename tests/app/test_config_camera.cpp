// acquire.camera: the file CAMERA.yaml, key by key.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/config/config_load.h"
#include "app/config/config_print.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

using test::TemporaryFolder;

constexpr const char* kCamera = "{width: 64, height: 48, fx: 60, fy: 61, cx: 31.5, cy: 23.5}";
const std::string kDepth = std::string("depth: ") + kCamera + "\n";

/// "[value, value, ...]"
std::string list_of(int count, const std::string& value) {
  std::string text = "[";
  for (int i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + value;
  return text + "]";
}

/// Of `depth_bias`, in the line after the depth camera's.
std::string bias(const std::string& columns, const std::string& rows, const std::string& scale,
                 const std::string& shift) {
  return kDepth + "depth_bias: {columns: " + columns + ", rows: " + rows + ", scale: " + scale +
         ", shift_per_m: " + shift + "}\n";
}

/// A file beside a configuration that names it in `key`.
class CameraYaml : public ::testing::Test {
 protected:
  [[nodiscard]] std::string file() const { return (folder_ / "CAMERA.yaml").string(); }

  [[nodiscard]] std::vector<ConfigProblem> apply(const std::string& text, LoadedConfig& loaded,
                                                 const std::string& key = "camera") const {
    std::ofstream(folder_ / "CAMERA.yaml") << text;
    return apply_yaml("acquire: {" + key + ": CAMERA.yaml}", "a.yaml", folder_.path(), loaded);
  }
  /// Null when it is refused, which fails the test.
  [[nodiscard]] std::shared_ptr<const ScannerCamera> read(const std::string& text) const {
    LoadedConfig loaded;
    for (const ConfigProblem& problem : apply(text, loaded)) ADD_FAILURE() << problem.where << problem.message;
    return loaded.config.acquire.camera;
  }
  /// What is wrong with it, without the names of the configuration and the file: "2:7: depth: ...", one a line.
  [[nodiscard]] std::string refusal_of(const std::string& text) const {
    const std::string begin = "acquire.camera: " + file() + ":";
    LoadedConfig loaded;
    std::string lines;
    for (const ConfigProblem& problem : apply(text, loaded)) {
      EXPECT_EQ(problem.where, "a.yaml:1:19");
      EXPECT_TRUE(problem.message.starts_with(begin)) << problem.message;
      if (!lines.empty()) lines += '\n';
      lines += problem.message.substr(std::min(begin.size(), problem.message.size()));
    }
    EXPECT_EQ(loaded.config.acquire.camera, nullptr);
    return lines;
  }

  TemporaryFolder folder_;
};

TEST_F(CameraYaml, HasAllOfAScanner) {
  const auto camera = read(
      "colour:\n  width: 640\n  height: 480\n  fx: 525\n  fy: -526\n  cx: 319.5\n  cy: 239.5\n"
      "  distortion: [0.1, -0.2, 0.001, 0.002, 0.3]\n"
      "depth: {width: 64, height: 48, fx: 60, fy: 61, cx: 31.5, cy: 23.5}\n"
      "T_colour_depth: [0.015, -0.02, 0.003, 0, 0, 0.6, 0.8]\n"
      "time_offset_ms: -10\n"
      "depth_bias:\n  columns: 4\n  rows: 5\n  scale: " +
      list_of(20, "0.01") + "\n  shift_per_m: " + list_of(20, "-0.002") + "\nserial: \"0123456\"\n");
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->colour, (CameraModel{{640, 480, 525, -526, 319.5, 239.5}, {0.1, -0.2, 0.001, 0.002, 0.3}}));
  EXPECT_EQ(camera->depth, (CameraModel{{64, 48, 60, 61, 31.5, 23.5}, {}}));
  ASSERT_TRUE(camera->T_colour_depth);
  EXPECT_TRUE(camera->T_colour_depth->translation().isApprox(Eigen::Vector3d(0.015, -0.02, 0.003)));
  const double turn = 2 * std::atan2(0.6, 0.8);
  EXPECT_TRUE(camera->T_colour_depth->linear().isApprox(
      Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1e-12));
  EXPECT_EQ(camera->colour_later_s, -0.01);
  ASSERT_TRUE(camera->depth_bias);
  EXPECT_EQ(camera->depth_bias->columns, 4);
  EXPECT_EQ(camera->depth_bias->rows, 5);
  EXPECT_EQ(camera->depth_bias->scale, std::vector<double>(20, 0.01));
  EXPECT_EQ(camera->depth_bias->shift_per_m, std::vector<double>(20, -0.002));
  EXPECT_EQ(camera->serial, "0123456");
}

TEST_F(CameraYaml, NeedsNoMoreThanOneCamera) {
  for (const char* name : {"colour", "depth"}) {
    const auto camera = read(std::string(name) + ": " + kCamera);
    ASSERT_TRUE(camera) << name;
    EXPECT_EQ(camera->colour.has_value(), name == std::string("colour"));
    EXPECT_EQ(camera->depth.has_value(), name == std::string("depth"));
    EXPECT_FALSE(camera->T_colour_depth || camera->colour_later_s || camera->depth_bias);
    EXPECT_TRUE(camera->serial.empty());
  }
}

TEST_F(CameraYaml, WithoutACameraIsRefused) {
  const std::string said = "1:1: expected colour: or depth:, as `calibrate camera` writes them";
  EXPECT_EQ(refusal_of("serial: 7\n"), said);
  EXPECT_EQ(refusal_of("time_offset_ms: 10\nT_colour_depth: [0, 0, 0, 0, 0, 0, 1]\n"), said);
}

TEST_F(CameraYaml, ThatIsNoMapIsRefused) {
  const std::string said = "expected a map of colour, depth, T_colour_depth, time_offset_ms, depth_bias, serial";
  EXPECT_TRUE(refusal_of("[1, 2, 3]\n").ends_with(said));
  EXPECT_TRUE(refusal_of("525 0 319.5\n").ends_with(said));
  EXPECT_TRUE(refusal_of("").ends_with(said));
}

TEST_F(CameraYaml, WithUnknownOrRepeatedKeysIsRefusedAtTheirPlace) {
  EXPECT_EQ(refusal_of(kDepth + "colours: red\n"),
            "2:1: unknown key 'colours'; known are colour, depth, T_colour_depth, time_offset_ms, depth_bias, serial");
  EXPECT_EQ(refusal_of("depth:\n  width: 64\n  focal: 3\n"),
            "3:3: depth: unknown key 'focal'; known are width, height, fx, fy, cx, cy, distortion");
  EXPECT_EQ(refusal_of("depth:\n  width: 64\n  width: 64\n"), "3:3: depth: duplicate key 'width'");
  EXPECT_NE(refusal_of(kDepth + kDepth).find("duplicate key 'depth'"), std::string::npos);
  EXPECT_EQ(refusal_of(kDepth + "depth_bias:\n  colums: 4\n"),
            "3:3: depth_bias: unknown key 'colums'; known are columns, rows, scale, shift_per_m");
}

TEST_F(CameraYaml, WithACameraThatIsNoneIsRefused) {
  EXPECT_EQ(refusal_of("colour: 7\n"), "1:9: colour: expected a map of width, height, fx, fy, cx, cy, distortion");
  EXPECT_EQ(refusal_of("colour: [525, 525, 319.5, 239.5]\n"),
            "1:9: colour: expected a map of width, height, fx, fy, cx, cy, distortion");
  EXPECT_EQ(refusal_of("colour: {fx: 1, fy: 1, cx: 1, cy: 1}\n"), "1:9: colour: width and height are missing");
  EXPECT_EQ(refusal_of("colour: {width: 4, fx: 1, fy: 1, cx: 1, cy: 1}\n"),
            "1:9: colour: width and height: give both or neither");
  EXPECT_EQ(refusal_of("colour: {width: 4, height: 3, fx: 1, fy: 1, cx: 1}\n"), "1:9: colour: 'cy' is missing");
  EXPECT_EQ(refusal_of("colour: {width: 4, height: 3, fx: 0, fy: 1, cx: 1, cy: 1}\n"),
            "1:9: colour: fx and fy must not be 0");
  EXPECT_EQ(refusal_of("colour:\n  width: 0\n"), "2:10: colour: expected a whole number of pixels, 1..65535, got '0'");
  EXPECT_EQ(refusal_of("colour:\n  height: 48.5\n"),
            "2:11: colour: expected a whole number of pixels, 1..65535, got '48.5'");
  EXPECT_EQ(refusal_of("colour:\n  distortion: [0, 0, 0, 0]\n"), "2:15: colour: expected a list of 5 numbers");
}

TEST_F(CameraYaml, WithNumbersThatAreNoneIsRefusedAtEach) {
  for (const char* wrong : {"wide", "nan", ".nan", "inf", "-.inf", "1e999", "''"}) {
    const std::string said = std::string("expected a number, got '") + (wrong[0] == '\'' ? "" : wrong) + "'";
    EXPECT_EQ(refusal_of(std::string("depth:\n  fx: ") + wrong + "\n"), "2:7: depth: " + said);
    EXPECT_EQ(refusal_of(std::string("depth:\n  distortion: [0, 0, ") + wrong + ", 0, 0]\n"), "2:22: depth: " + said);
    EXPECT_EQ(refusal_of(kDepth + "T_colour_depth: [" + wrong + ", 0, 0, 0, 0, 0, 1]\n"),
              "2:18: T_colour_depth: " + said);
    EXPECT_EQ(refusal_of(kDepth + "time_offset_ms: " + wrong + "\n"), "2:17: time_offset_ms: " + said);
    EXPECT_EQ(refusal_of(kDepth + "depth_bias:\n  columns: 4\n  rows: 4\n  shift_per_m: " + list_of(16, "0") +
                         "\n  scale: " + list_of(16, wrong) + "\n"),
              "6:11: depth_bias: " + said);
  }
  EXPECT_EQ(refusal_of(kDepth + "time_offset_ms: [10]\n"), "2:17: time_offset_ms: expected a number, got ''");
}

TEST_F(CameraYaml, WithAPoseThatIsNoneIsRefused) {
  EXPECT_EQ(refusal_of(kDepth + "T_colour_depth: [0, 0, 0, 0, 0, 1]\n"),
            "2:17: T_colour_depth: expected a list of 7 numbers");
  EXPECT_EQ(refusal_of(kDepth + "T_colour_depth: none\n"), "2:17: T_colour_depth: expected a list of 7 numbers");
  EXPECT_EQ(refusal_of(kDepth + "T_colour_depth: [0, 0, 0, 1, 0, 0, 1]\n"),
            "2:17: T_colour_depth: expected tx, ty, tz, qx, qy, qz, qw with a quaternion of length 1, got 1.41421");
}

TEST_F(CameraYaml, TakesAPoseThatIsRoundedToThreeDigits) {
  const auto camera = read(kDepth + "T_colour_depth: [0, 0, 0, 0.707, 0, 0, 0.707]\n");
  ASSERT_TRUE(camera);
  EXPECT_TRUE(camera->T_colour_depth->linear().isUnitary(1e-12)) << "it is a turn all the same";
}

TEST_F(CameraYaml, WithATimeBeyondASecondIsRefused) {
  EXPECT_EQ(refusal_of(kDepth + "time_offset_ms: 1001\n"), "2:17: time_offset_ms: 1001, expected -1000 to 1000");
}

TEST_F(CameraYaml, WithoutASerialNumberWhereOneIsPromisedIsRefused) {
  EXPECT_EQ(refusal_of(kDepth + "serial: ''\n"), "2:9: serial: expected the scanner's serial number");
  EXPECT_EQ(refusal_of(kDepth + "serial: [7]\n"), "2:9: serial: expected the scanner's serial number");
}

TEST_F(CameraYaml, WithABiasOfAnotherSizeIsRefused) {
  const std::string good = list_of(20, "0");
  EXPECT_TRUE(read(bias("4", "5", good, good)));
  for (const int count : {0, 19, 21}) {
    EXPECT_TRUE(refusal_of(bias("4", "5", list_of(count, "0"), good)).ends_with("expected a list of 20 numbers"));
    EXPECT_TRUE(refusal_of(bias("4", "5", good, list_of(count, "0"))).ends_with("expected a list of 20 numbers"));
  }
  EXPECT_TRUE(refusal_of(bias("4", "5", "0", good)).ends_with("expected a list of 20 numbers"));
  for (const char* wrong : {"3", "65", "-4", "4.5", "four", "[4]"}) {
    EXPECT_NE(refusal_of(bias(wrong, "5", good, good)).find("columns: expected a whole number, 4..64"),
              std::string::npos);
    EXPECT_NE(refusal_of(bias("4", wrong, good, good)).find("rows: expected a whole number, 4..64"), std::string::npos);
  }
}

TEST_F(CameraYaml, WithABiasBeyondItsBoundsIsRefused) {
  const std::string good = list_of(16, "0");
  EXPECT_TRUE(read(bias("4", "4", list_of(16, "0.1"), list_of(16, "-0.1"))));
  EXPECT_TRUE(refusal_of(bias("4", "4", list_of(16, "0.11"), good)).ends_with("0.11, expected -0.1 to 0.1"));
  EXPECT_TRUE(refusal_of(bias("4", "4", good, list_of(16, "-2"))).ends_with("-2, expected -0.1 to 0.1"));
}

TEST_F(CameraYaml, WithHalfABiasIsRefused) {
  EXPECT_EQ(refusal_of(kDepth + "depth_bias:\n  columns: 4\n"),
            "3:3: depth_bias: expected all of columns, rows, scale, shift_per_m");
  EXPECT_EQ(refusal_of(kDepth + "depth_bias: 0.01\n"),
            "2:13: depth_bias: expected a map of columns, rows, scale, shift_per_m");
  EXPECT_EQ(refusal_of(std::string("colour: ") + kCamera + "\ndepth_bias: {columns: 4, rows: 4, scale: " +
                       list_of(16, "0") + ", shift_per_m: " + list_of(16, "0") + "}\n"),
            "1:1: depth_bias belongs to a depth camera, expected depth: too");
}

TEST_F(CameraYaml, SaysAllThatIsWrongAtOnce) {
  EXPECT_EQ(refusal_of(kDepth + "colours: red\ntime_offset_ms: late\nserial: ''\n"),
            "2:1: unknown key 'colours'; known are colour, depth, T_colour_depth, time_offset_ms, depth_bias, serial\n"
            "3:17: time_offset_ms: expected a number, got 'late'\n"
            "4:9: serial: expected the scanner's serial number");
}

TEST_F(CameraYaml, ThatIsNoYamlIsRefusedWithItsLine) {
  EXPECT_TRUE(refusal_of(kDepth + "colour: {width: 64\n").starts_with("3:")) << refusal_of(kDepth + "colour: {");
}

TEST_F(CameraYaml, CutAnywhereIsReadOrRefusedAndNeverHalf) {
  const std::string whole = bias("4", "4", list_of(16, "0.01"), list_of(16, "0.002"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    LoadedConfig loaded;
    const auto problems = apply(whole.substr(0, size), loaded);
    const auto& camera = loaded.config.acquire.camera;
    ASSERT_EQ(camera == nullptr, !problems.empty()) << size;
    if (!camera) continue;
    EXPECT_TRUE(camera->depth) << size;
    EXPECT_EQ(camera->depth_bias.has_value(), size + 1 >= whole.size()) << size;
  }
}

TEST_F(CameraYaml, IsNamedAndNotWritten) {
  LoadedConfig loaded;
  const auto said = [&](const std::string& text) {
    const auto problems = apply_yaml(text, "a.yaml", folder_.path(), loaded);
    return problems.empty() ? "" : problems.front().where + ": " + problems.front().message;
  };
  EXPECT_NE(said("acquire: {camera: none.yaml}").find("no such file"), std::string::npos);
  for (const char* value : {"[525, 525, 319.5, 239.5]", "{fx: 1}", "''"}) {
    EXPECT_EQ(said(std::string("acquire: {camera: ") + value + "}"),
              "a.yaml:1:19: acquire.camera: expected the name of a file that `calibrate camera` wrote");
  }
}

TEST_F(CameraYaml, IsGivenBackToTheRecordingByAuto) {
  LoadedConfig loaded;
  ASSERT_TRUE(apply(kDepth, loaded).empty());
  ASSERT_TRUE(loaded.config.acquire.camera);
  EXPECT_TRUE(apply_yaml("acquire: {camera: auto}", "a.yaml", "", loaded).empty());
  EXPECT_FALSE(loaded.config.acquire.camera);
}

TEST_F(CameraYaml, IsPrintedByItsNameAndReadBackFromAnotherFolder) {
  LoadedConfig loaded;
  ASSERT_TRUE(apply(bias("4", "4", list_of(16, "0.01"), list_of(16, "0")), loaded).empty());
  const std::string yaml = config_to_yaml(loaded.config);
  EXPECT_NE(yaml.find("\n  camera: " + file()), std::string::npos) << yaml;
  EXPECT_EQ(nlohmann::json::parse(config_to_json(loaded.config))["acquire"]["camera"], file());

  const TemporaryFolder elsewhere;
  LoadedConfig back;
  ASSERT_TRUE(apply_yaml(yaml, "printed.yaml", elsewhere.path(), back).empty());
  ASSERT_TRUE(back.config.acquire.camera);
  EXPECT_EQ(back.config.acquire.camera->depth, loaded.config.acquire.camera->depth);
  EXPECT_EQ(back.config.acquire.camera->depth_bias->scale, loaded.config.acquire.camera->depth_bias->scale);
  EXPECT_EQ(config_to_yaml(back.config), yaml);
}

TEST_F(CameraYaml, NamedFromTheWorkingFolderIsPrintedWithItsWholeName) {
  std::ofstream(folder_ / "CAMERA.yaml") << kDepth;
  const auto relative = std::filesystem::relative(file());
  LoadedConfig loaded;
  ASSERT_TRUE(apply_assignment("acquire.camera=" + relative.string(), loaded).empty());
  EXPECT_EQ(std::filesystem::path(loaded.config.acquire.camera->file), std::filesystem::path(file()));
}

TEST_F(CameraYaml, IsTakenByIntrinsicsForItsDepthCamera) {
  LoadedConfig loaded;
  ASSERT_TRUE(
      apply("colour: {width: 4, height: 3, fx: 1, fy: 1, cx: 1, cy: 1}\n" + kDepth, loaded, "intrinsics").empty());
  EXPECT_EQ(loaded.config.acquire.intrinsics, (CameraModel{{64, 48, 60, 61, 31.5, 23.5}, {}}));
  EXPECT_FALSE(loaded.config.acquire.camera);

  LoadedConfig none;
  const auto problems = apply(std::string("colour: ") + kCamera, none, "intrinsics");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems.front().message.find("only the colour camera is calibrated"), std::string::npos);
  EXPECT_NE(apply(kDepth + "colours: red\n", none, "intrinsics").front().message.find(":2:1: unknown key 'colours'"),
            std::string::npos);
}

}  // namespace
}  // namespace scanknit
