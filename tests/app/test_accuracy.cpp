// The main job measured against the exact surface of synthetic scenes, at full picture size.
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

/// Scans `scene`, fuses it and returns {"distance": ..., "report": ...}.
Json measure(const std::string& scene, const std::vector<std::string>& scanner, const char* voxel_size = "4mm") {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  std::vector<std::string> synth = {"synth", scene, "-o", recording, "--quiet"};
  synth.insert(synth.end(), scanner.begin(), scanner.end());
  EXPECT_EQ(scanknit_command(synth).exit_code, 0);
  const std::string mesh = folder / "mesh.ply";
  const Outcome run = scanknit_command(
      {"run", recording, "-o", mesh, "--set", std::string("fusion.voxel_size=") + voxel_size, "--json", "--quiet"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Outcome distance = scanknit_command({"distance", mesh, recording, "--json"});
  EXPECT_EQ(distance.exit_code, 0) << distance.err;
  return {{"distance", Json::parse(distance.out)}, {"report", Json::parse(run.out)}};
}

TEST(Accuracy, ANoiseFreeTurntableObjectIsWithinAQuarterOfAMillimetreInTheMean) {
  const Json result = measure("turntable", {"--frames", "120"});
  EXPECT_LE(result["distance"]["area"]["mean_m"].get<double>(), 0.25e-3);
  EXPECT_LE(result["distance"]["vertices"]["mean_m"].get<double>(), 0.25e-3);
  EXPECT_EQ(result["distance"]["share_complete"].get<double>(), 1.0);
}

TEST(Accuracy, ATurntableObjectSeenFromAllSidesIsOneClosedMeshOfItsOwnTopology) {
  const Json mesh = measure("turntable", {"--frames", "120", "--noise"})["report"]["mesh"];
  EXPECT_EQ(mesh["components"], 1);
  EXPECT_EQ(mesh["boundary_edges"], 0);
  EXPECT_EQ(mesh["non_manifold_edges"], 0);
  EXPECT_EQ(mesh["non_manifold_vertices"], 0);
  EXPECT_EQ(mesh["euler"], 0);  // one handle
}

TEST(Accuracy, KinectNoiseDoesNotSpoilATurntableObject) {
  const Json result = measure("turntable", {"--frames", "120", "--noise"});
  EXPECT_LE(result["distance"]["area"]["mean_m"].get<double>(), 0.25e-3);  // a fifth of one depth reading's sigma
}

/// A plate of 20 cm x 15 cm x 6 mm as a mesh file.
std::string thin_plate(const TempFolder& folder) {
  const std::string file = folder / "plate.obj";
  std::ofstream out(file);
  for (const char* z : {"-0.075", "0.075"}) {
    for (const char* corner : {"-0.1 -0.003 ", "0.1 -0.003 ", "0.1 0.003 ", "-0.1 0.003 "}) {
      out << "v " << corner << z << '\n';
    }
  }
  out << "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";
  return file;
}

TEST(Accuracy, APlateOf6MillimetresSeenFrom60CentimetresKeepsBothSides) {
  const TempFolder folder;
  const std::string plate = thin_plate(folder);
  const Json exact = measure(plate, {"--frames", "120", "--size", "20cm"}, "2mm");
  EXPECT_EQ(exact["report"]["mesh"]["components"], 1);
  EXPECT_EQ(exact["report"]["mesh"]["is_closed"], true);
  EXPECT_EQ(exact["report"]["mesh"]["euler"], 2);  // no hole from one side to the other
  const Json noisy = measure(plate, {"--frames", "120", "--size", "20cm", "--noise"}, "2mm");
  EXPECT_EQ(noisy["report"]["mesh"]["components"], 1);
  for (const Json& result : {exact["distance"], noisy["distance"]}) {
    EXPECT_LE(result["area"]["p95_m"].get<double>(), 1e-3);  // sides that melt would be off by half a plate
    EXPECT_LE(result["completeness"]["p95_m"].get<double>(), 1e-3);
  }
}

TEST(Accuracy, ADeskOrbitIsTrackedFromScratchAsWellAsFromTruePoses) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  ASSERT_EQ(scanknit_command({"synth", "desk", "-o", recording, "--frames", "120", "--noise", "--quiet"}).exit_code, 0);
  const auto scan = [&](const std::string& poses) {
    const std::string mesh = folder / (poses + ".ply");
    const Outcome run = scanknit_command({"run", recording, "-o", mesh, "--poses", poses, "--trajectory",
                                          folder / (poses + ".txt"), "--set", "fusion.voxel_size=4mm", "--quiet"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const Outcome distance = scanknit_command({"distance", mesh, recording, "--json"});
    EXPECT_EQ(distance.exit_code, 0) << distance.err;
    return Json::parse(distance.out)["area"]["mean_m"].get<double>();
  };
  const double true_error_m = scan("recording");
  const double tracked_error_m = scan("track");
  const TrajectoryError path = trajectory_error(folder / "track.txt", folder / "recording.txt");
  std::cout << "desk, tracked: ATE RMSE " << 1000 * path.rmse_m << " mm, surface error " << 1000 * tracked_error_m
            << " mm; with true poses " << 1000 * true_error_m << " mm\n";
  EXPECT_EQ(path.pairs, 120u);
  EXPECT_LE(path.rmse_m, 5e-3);
  EXPECT_LE(tracked_error_m, 1.5 * true_error_m);
}

}  // namespace
}  // namespace scanknit
