// A camera that is turned quickly and reads its rows one after the other, by the built program.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

/// Turns of up to 120 degrees a second before the desk. `shutter_s`: of depth and of colour.
void record(const std::string& recording, const std::string& shutter_s) {
  const Outcome synth = scanknit_command(
      {"synth", "desk", "-o", recording, "--frames", "60", "--width", "320", "--height", "240", "--path", "turns",
       "--sensor-set", "shutter.depth=" + shutter_s, "--sensor-set", "shutter.colour=" + shutter_s, "--quiet"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
}

struct Scanned {
  TrajectoryError error;
  Json tracking;
  double mean_surface_error_m = 0;
};

Scanned scan(const TempFolder& folder, const std::string& poses, const std::string& readout_s) {
  const std::string name = poses + readout_s;
  const std::string output = folder / name;
  const Outcome run =
      scanknit_command({"run", folder / "recording", "-o", output, "--trajectory", folder / (name + ".txt"), "--poses",
                        poses, "--set", "fusion.voxel_size=1cm", "--set", "acquire.readout=" + readout_s, "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  Scanned scanned;
  scanned.error = trajectory_error(folder / (name + ".txt"), folder / "recording0.txt");
  scanned.tracking = Json::parse(read_text(output + "/report.json"), nullptr, false)["tracking"];
  const Outcome distance = scanknit_command({"distance", output + "/model.glb", folder / "recording", "--json"});
  scanned.mean_surface_error_m = Json::parse(distance.out, nullptr, false)["area"]["mean_m"].get<double>();
  return scanned;
}

TEST(RollingShutter, IsTakenOutOfAQuickTurn) {
  const TempFolder folder;
  record(folder / "recording", "30ms");
  scan(folder, "recording", "0");  // writes the true trajectory
  const Scanned as_if_at_once = scan(folder, "track", "0");
  const Scanned known = scan(folder, "track", "0.03");
  EXPECT_EQ(known.tracking["states"]["ok"], 60);
  EXPECT_EQ(known.error.pairs, 60U);
  EXPECT_LT(known.error.rmse_m, 0.5 * as_if_at_once.error.rmse_m);
  EXPECT_LT(known.mean_surface_error_m, 0.7 * as_if_at_once.mean_surface_error_m);
}

/// What `run` says and reports of a Kinect's quick turns, where only depth tells the sensor.
struct Kinect {
  std::string said;
  Json report;
};

Kinect scan_kinect(const std::vector<std::string>& sensor) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  std::vector<std::string> arguments = {"synth",    "desk",    "-o",       recording, "--frames", "110",
                                        "--width",  "320",     "--height", "240",     "--path",   "turns",
                                        "--sensor", "kinect1", "--seed",   "3",       "--quiet"};
  arguments.insert(arguments.end(), sensor.begin(), sensor.end());
  const Outcome synth = scanknit_command(arguments);
  EXPECT_EQ(synth.exit_code, 0) << synth.err;
  const Outcome run =
      scanknit_command({"run", recording, "-o", folder / "out", "--poses", "track", "--set", "fusion.voxel_size=1cm"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return {run.err, Json::parse(read_text(folder / "out/report.json"), nullptr, false)};
}

TEST(RollingShutter, IsTriedWhereFramesFitBadlyAndOnlyDepthTellsTheSensor) {
  const Kinect kinect = scan_kinect({});
  EXPECT_NE(kinect.said.find("the frames are scanned again with a rolling shutter of 31 ms"), std::string::npos)
      << kinect.said;
  EXPECT_EQ(kinect.report["frames"]["lost"], 0);
  EXPECT_EQ(kinect.report["frames"]["fused"], kinect.report["frames"]["read"]);
  EXPECT_GT(kinect.report["config"]["acquire"]["readout"], 0.03);
}

TEST(RollingShutter, IsNotKeptWhereTheSensorHasNone) {
  const Kinect kinect = scan_kinect({"--sensor-set", "shutter=off"});
  EXPECT_NE(kinect.said.find("the rolling shutter hardly improves the fit"), std::string::npos) << kinect.said;
  EXPECT_EQ(kinect.report["frames"]["fused"], kinect.report["frames"]["read"]);
  EXPECT_EQ(kinect.report["config"]["acquire"]["readout"], 0);
}

}  // namespace
}  // namespace scanknit
