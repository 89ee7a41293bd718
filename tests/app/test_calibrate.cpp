// `calibrate target` and `calibrate camera` as a user calls them, on rendered pictures of a board.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "tests/app/suite_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A board before a scanner with a lens, noise, an error of depth and a delay of colour, of which the recording tells
/// nothing: it states another focal length and centre.
class Calibrate : public SuiteFolder {
 protected:
  static constexpr double kTrueFocal_px = 525, kTrueCentreX_px = 319.5, kTrueCentreY_px = 239.5;

  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    std::vector<std::string> synth = {"synth", "calibration_board", "-o",  recording(), "--frames", "80", "--width",
                                      "640",   "--height",          "480", "--quiet"};
    for (const char* fault : {"lens.k1=0.05", "lens.k2=-0.08", "colour.noise=0.01", "camera.focal=3%", "bias.share=3%",
                              "colour.delay=0.01", "time.rate=10"}) {
      synth.insert(synth.end(), {"--sensor-set", fault});
    }
    const Outcome made = scanknit_command(synth);
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }

  static Outcome calibrate(const std::string& pictures, const std::string& target, const std::string& output,
                           const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"calibrate", "camera", pictures, "--target", target, "-o", place(output)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  static std::string target() { return recording() + "/target.yaml"; }
  static std::string written(const std::string& name, const std::string& text) {
    std::ofstream(place(name)) << text;
    return place(name);
  }
};

TEST_F(Calibrate, FindsTheCameraThatTheRecordingStatesWrongly) {
  const Outcome outcome = calibrate(recording(), target(), "camera.yaml", {"--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  const auto deviation = json["standard_deviation"];
  const std::array<std::pair<const char*, double>, 4> truth = {
      {{"fx", kTrueFocal_px}, {"fy", kTrueFocal_px}, {"cx", kTrueCentreX_px}, {"cy", kTrueCentreY_px}}};
  for (const auto& [key, value] : truth) {
    const double found = json["colour"][key].get<double>();
    EXPECT_NEAR(found, value, 3 * deviation[key].get<double>()) << key;
    EXPECT_NEAR(found, value, key[0] == 'f' ? 0.001 * value : 0.5) << key;
    EXPECT_EQ(json["depth"][key], json["colour"][key]) << "depth is registered to colour";
  }
  EXPECT_NEAR(json["colour"]["distortion"][0].get<double>(), 0.05, 3 * deviation["distortion"][0].get<double>());
  EXPECT_LT(json["error_px"].get<double>(), 0.3);
}

TEST_F(Calibrate, MeasuresTheErrorOfDepthAndTheDelayOfColour) {
  const Outcome outcome = calibrate(recording(), target(), "depth.yaml", {"--json", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json measured = Json::parse(outcome.out)["measured_depth"];
  EXPECT_NEAR(measured["time_offset_ms"]["value"].get<double>(), 10, 1);
  EXPECT_LT(measured["time_offset_ms"]["standard_deviation"].get<double>(), 1);
  EXPECT_LT(measured["error_after_m"].get<double>(), measured["error_before_m"].get<double>() / 2);
  EXPECT_EQ(measured["depth_bias"]["standard_deviations"].size(), 3u);
  EXPECT_TRUE(measured["T_colour_depth"].is_null()) << "depth is registered to colour";
  EXPECT_TRUE(measured["not_measured"].empty()) << measured["not_measured"];
  const std::string file = read_text(place("depth.yaml"));
  for (const char* key : {"\ntime_offset_ms: ", "\ndepth_bias:", "\n  scale: [", "\n  shift_per_m: ["}) {
    EXPECT_NE(file.find(key), std::string::npos) << key;
  }
}

TEST_F(Calibrate, WhatItWritesIsTakenByARun) {
  ASSERT_EQ(calibrate(recording(), target(), "used.yaml").exit_code, 0);
  const Outcome run = scanknit_command({"run", recording(), "-o", place("out"), "--to", "9", "--set",
                                        "fusion.voxel_size=1cm", "--set", "acquire.intrinsics=" + place("used.yaml")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json used = report("out")["config"]["acquire"]["intrinsics"];
  EXPECT_EQ(used["width"], 640);
  EXPECT_NEAR(used["fx"].get<double>(), kTrueFocal_px, 0.001 * kTrueFocal_px);
  EXPECT_NE(used["distortion"][0], 0);
}

TEST_F(Calibrate, WhatItWritesGivesTheSameMeshAsTheCameraAndAsTheIntrinsicsOfARegisteredRecording) {
  ASSERT_EQ(calibrate(recording(), target(), "all.yaml").exit_code, 0);
  const std::string all = read_text(place("all.yaml"));
  const std::size_t lenses_end = all.find("time_offset_ms:");
  ASSERT_NE(lenses_end, std::string::npos);
  written("both.yaml", all.substr(0, lenses_end));  // acquire.intrinsics takes nothing else
  const auto mesh_with = [&](const std::string& setting) {
    const Outcome run = scanknit_command({"run", recording(), "-o", place("meshes"), "--to", "9", "--set",
                                          "fusion.voxel_size=1cm", "--set", setting, "--quiet"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_text(fs::path(place("meshes")) / "model.ply");
  };
  const std::string as_intrinsics = mesh_with("acquire.intrinsics=" + place("both.yaml"));
  const std::string as_camera = mesh_with("acquire.camera=" + place("both.yaml"));
  EXPECT_EQ(report("meshes")["config"]["acquire"]["camera"],
            fs::absolute(place("both.yaml")).lexically_normal().string());
  EXPECT_GT(as_camera.size(), 1000u);
  EXPECT_TRUE(as_camera == as_intrinsics);
  EXPECT_TRUE(as_camera != mesh_with("acquire.camera=" + place("all.yaml"))) << "with the error of depth taken out";
  EXPECT_TRUE(as_camera != mesh_with("acquire.camera=auto")) << "the recording states another camera";
}

TEST_F(Calibrate, AFileOfAnotherResolutionIsRefusedByARun) {
  const std::string camera =
      written("other.yaml",
              "depth: {width: 320, height: 240, fx: 262, fy: 262, cx: 160, cy: 120, distortion: [0, 0, 0, 0, 0]}");
  const Outcome run =
      scanknit_command({"run", recording(), "-o", place("none"), "--set", "acquire.intrinsics=" + camera});
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_NE(run.err.find("the picture is 640 x 480, its camera 320 x 240"), std::string::npos) << run.err;
}

TEST_F(Calibrate, TakesAFolderOfPicturesToo) {
  const Outcome outcome =
      calibrate(recording() + "/color", target(), "pictures.yaml", {"--json", "--depth", "--quiet"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = Json::parse(outcome.out);
  EXPECT_TRUE(json["colour"].is_null());
  EXPECT_NEAR(json["depth"]["fx"].get<double>(), kTrueFocal_px, 0.001 * kTrueFocal_px);
}

TEST_F(Calibrate, SaysWhatIsWrongWithTheBoard) {
  struct Fault {
    std::string target, part;
    int exit_code;
  };
  for (const Fault& fault : std::vector<Fault>{
           {written("swapped.yaml", "{type: aprilgrid, columns: 4, rows: 6, size: 40mm}"), "another board", 4},
           {written("typo.yaml", "{type: aprilgrid, colums: 4, rows: 6, size: 40mm}"),
            "unknown or repeated key 'colums'", 3},
           {written("short.yaml", "{type: aprilgrid, rows: 6, size: 40mm}"), "'columns' is missing", 3},
           {written("none.yaml", "{type: aprilgrid, columns: 6, rows: 4, size: 0}"), "size: 0", 3},
           {written("word.yaml", "{type: dots, columns: 6, rows: 4, size: 40mm}"), "expected aprilgrid or charuco", 3},
           {place("absent.yaml"), "no such file", 4}}) {
    const Outcome outcome = calibrate(recording(), fault.target, "no.yaml");
    EXPECT_EQ(outcome.exit_code, fault.exit_code) << outcome.err;
    EXPECT_NE(outcome.err.find(fault.part), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(place("no.yaml")));
  }
}

TEST_F(Calibrate, SaysWhatIsWrongWithThePictures) {
  fs::create_directories(place("few"));
  for (const char* name : {"000000.png", "000010.png", "000020.png"}) {
    fs::copy(fs::path(recording()) / "color" / name, fs::path(place("few")) / name);
  }
  const Outcome few = calibrate(place("few"), target(), "no.yaml");
  EXPECT_EQ(few.exit_code, 6);
  EXPECT_NE(few.err.find("expected at least 8"), std::string::npos) << few.err;

  fs::create_directories(place("same"));
  for (int i = 0; i < 12; ++i) {
    fs::copy(fs::path(recording()) / "color/000010.png", fs::path(place("same")) / (std::to_string(i) + ".png"));
  }
  const Outcome same = calibrate(place("same"), target(), "no.yaml");
  EXPECT_EQ(same.exit_code, 6);
  EXPECT_NE(same.err.find("too alike"), std::string::npos) << same.err;

  ASSERT_EQ(scanknit_command({"synth", "sphere", "--frames", "8", "--width", "160", "--height", "120", "-o",
                              place("sphere"), "--quiet"})
                .exit_code,
            0);
  const Outcome nothing = calibrate(place("sphere"), target(), "no.yaml");
  EXPECT_EQ(nothing.exit_code, 4);
  EXPECT_NE(nothing.err.find("no board is found in 8 pictures"), std::string::npos) << nothing.err;

  std::ofstream(fs::path(place("few")) / "9.png") << "no picture";
  EXPECT_EQ(calibrate(place("few"), target(), "no.yaml").exit_code, 4);
  EXPECT_EQ(calibrate(place("absent"), target(), "no.yaml").exit_code, 4);
  EXPECT_FALSE(fs::exists(place("no.yaml")));
}

TEST_F(Calibrate, TellsWhenTheOutputCannotBeWritten) {
  EXPECT_EQ(calibrate(recording(), target(), "recording").exit_code, 8) << "a folder";
}

TEST(CalibrateTarget, WritesTheBoardAndItsDescription) {
  const TempFolder folder;
  for (const std::string name : {"board.pdf", "chess.svg"}) {
    const bool is_chess = name == "chess.svg";
    const Outcome outcome = scanknit_command(
        {"calibrate", "target", "-o", folder / name, "--type", is_chess ? "charuco" : "aprilgrid", "--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json["corners"], is_chess ? 8 * 5 : 6 * 4 * 4);
    EXPECT_EQ(read_text(folder / name).substr(0, 5), is_chess ? "<?xml" : "%PDF-");
  }
  EXPECT_NE(read_text(folder / "board.yaml").find("type: aprilgrid"), std::string::npos);
  EXPECT_NE(read_text(folder / "chess.yaml").find("columns: 9  # of squares"), std::string::npos);
}

TEST(CalibrateTarget, RefusesWhatDoesNotFit) {
  const TempFolder folder;
  const auto refused = [&](const std::vector<std::string>& more, const std::string& part, int exit_code) {
    std::vector<std::string> arguments = {"calibrate", "target", "-o", folder / "board.pdf"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = scanknit_command(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "board.pdf"));
  };
  refused({"--size", "50mm"}, "the largest --size that fits is", 2);
  refused({"--columns", "40", "--rows", "40"}, "1600 tags", 2);
  refused({"--size", "none"}, "expected a length", 2);
  refused({"-o", folder / "board.png"}, "", 2);
}

}  // namespace
}  // namespace scanknit
