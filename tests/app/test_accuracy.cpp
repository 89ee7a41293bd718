// The main job measured against the exact surface of synthetic scenes, at full picture size.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

/// Scans `scene`, fuses it with 4 mm voxels and returns {"distance": ..., "report": ...}.
Json measure(const std::string& scene, const std::vector<std::string>& scanner) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  std::vector<std::string> synth = {"synth", scene, "-o", recording, "--quiet"};
  synth.insert(synth.end(), scanner.begin(), scanner.end());
  EXPECT_EQ(scanknit_command(synth).exit_code, 0);
  const std::string mesh = folder / "mesh.ply";
  const Outcome run =
      scanknit_command({"run", recording, "-o", mesh, "--set", "fusion.voxel_size=4mm", "--json", "--quiet"});
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

}  // namespace
}  // namespace scanknit
