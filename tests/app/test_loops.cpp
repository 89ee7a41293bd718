// Walks that come back: drift is distributed, and what only looks like a place seen before is not taken for it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A tracked scan of a synthetic scene in pictures of 320 x 240.
class Walk {
 public:
  Walk(const std::string& scene, int frames, int seed) {
    const Outcome synth =
        scanknit_command({"synth", scene, "-o", folder_ / "recording", "--frames", std::to_string(frames), "--width",
                          "320", "--height", "240", "--noise", "--seed", std::to_string(seed), "--jpeg", "--quiet"});
    EXPECT_EQ(synth.exit_code, 0) << synth.err;
    write_truth();
  }

  /// The outcome's report.
  [[nodiscard]] Json run(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run",          folder_ / "recording",
                                          "-o",           folder_ / name,
                                          "--poses",      "track",
                                          "--preset",     "room",
                                          "--set",        "fusion.voxel_size=2cm",
                                          "--set",        "acquire.sensor=none",  // far walls: the walk drifts
                                          "--set",        "acquire.max_depth=5m",
                                          "--trajectory", folder_ / (name + ".txt"),
                                          "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = scanknit_command(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::ifstream report(folder_ / (name + "/report.json"));
    return Json::parse(report, nullptr, /*allow_exceptions=*/false);
  }
  [[nodiscard]] TrajectoryError error(const std::string& name) const {
    return trajectory_error(folder_ / (name + ".txt"), folder_ / "truth.txt");
  }
  /// How far the mesh is from the scene, by area.
  [[nodiscard]] double mean_distance_m(const std::string& name) const {
    const Outcome outcome =
        scanknit_command({"distance", folder_ / (name + "/model.ply"), folder_ / "recording", "--json"});
    return Json::parse(outcome.out).at("area").at("mean_m").get<double>();
  }
  [[nodiscard]] std::string model(const std::string& name) const { return read_text(folder_ / (name + "/model.ply")); }

 private:
  /// The places of trajectory.log, four rows of a matrix after each line of numbers.
  void write_truth() const {
    std::ifstream log(folder_ / "recording/trajectory.log");
    std::ofstream truth(folder_ / "truth.txt");
    std::string line;
    for (int i = 0; std::getline(log, line); ++i) {
      double m[3][4] = {};
      for (auto& row : m) {
        for (double& value : row) log >> value;
      }
      std::getline(log, line);
      std::getline(log, line);  // 0 0 0 1
      truth << i << ' ' << m[0][3] << ' ' << m[1][3] << ' ' << m[2][3] << " 0 0 0 1\n";
    }
  }

  TempFolder folder_;
};

TEST(Loops, TheDriftOfARoundIsDistributed) {
  // Of the seeds 1 to 4 the one that drifts most. It runs: below 2 m/s colour would hold it (docs/loop_closure.md).
  const Walk walk("gallery", 400, 3);
  const Json open = walk.run("open", {"--set", "fusion.loop_closure=false"});
  EXPECT_TRUE(open["tracking"]["loops"].is_null());
  const Json closed = walk.run("closed");
  const Json& loops = closed["tracking"]["loops"];
  ASSERT_TRUE(loops["is_corrected"]);
  EXPECT_GT(loops["drift_m"], 0.1);  // bare walls: 38 cm in 28 m
  EXPECT_EQ(walk.error("closed").pairs, 400u);
  EXPECT_GT(walk.error("open").rmse_m, 0.03);
  EXPECT_LT(walk.error("closed").rmse_m, 0.5 * walk.error("open").rmse_m);
  EXPECT_LT(walk.mean_distance_m("closed"), walk.mean_distance_m("open"));

  const Json one_thread = walk.run("one", {"--threads", "1"});
  EXPECT_EQ(one_thread["tracking"]["loops"], loops);
  EXPECT_EQ(walk.model("one"), walk.model("closed")) << "not the same bytes";
}

TEST(Loops, ACornerThatLooksTheSameIsNotTakenForTheFirst) {
  const Walk walk("twins", 200, 1);
  const Json loops = walk.run("out")["tracking"]["loops"];
  EXPECT_FALSE(loops["is_corrected"]);
  bool was_tempted = false;
  for (const Json& pair : loops["pairs"]) {
    const bool is_twin = pair["to"].get<int>() - pair["from"].get<int>() > 120;
    was_tempted |= is_twin;
    if (is_twin) {
      EXPECT_EQ(pair["refused"], "farther than the walk can have drifted");
    }
  }
  EXPECT_TRUE(was_tempted) << "the corners were not even compared";
  EXPECT_LT(walk.error("out").rmse_m, 0.02);
}

/// A walk round a room with all faults of a phone's LiDAR: it meets its beginning 20 cm beside it, and frames that see
/// both are lost.
TEST(Loops, AnEndThatWasLostWhereItMeetsTheBeginningIsJoinedToIt) {
  const TempFolder folder;
  const Outcome synth =
      scanknit_command({"synth", "room", "-o", folder / "recording", "--sensor", "phone_lidar", "--path", "hand",
                        "--frames", "300", "--width", "192", "--height", "144", "--seed", "5", "--quiet"});
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  const auto run = [&](const std::string& name, const std::string& poses, const std::string& loops) {
    const Outcome outcome = scanknit_command({"run", folder / "recording", "-o", folder / name, "--poses", poses,
                                              "--set", "fusion.voxel_size=2cm", "--set", "fusion.loop_closure=" + loops,
                                              "--trajectory", folder / (name + ".txt"), "--quiet"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(read_text(folder / (name + "/report.json")), nullptr, /*allow_exceptions=*/false);
  };
  run("true", "recording", "false");
  const Json open = run("open", "track", "false");
  const Json closed = run("closed", "track", "true");
  EXPECT_GT(open["frames"]["lost"], 5);
  EXPECT_EQ(closed["frames"]["lost"], 0);
  EXPECT_EQ(closed["frames"]["fused"], 300);
  EXPECT_EQ(closed["tracking"]["found_later"], open["frames"]["lost"]);
  EXPECT_TRUE(closed["tracking"]["loops"]["is_corrected"]);
  EXPECT_LT(closed["doubled"]["share"], 0.1 * open["doubled"]["share"].get<double>());
  const auto rmse_m = [&](const char* name) {
    return trajectory_error(folder / (std::string(name) + ".txt"), folder / "true.txt").rmse_m;
  };
  EXPECT_LT(rmse_m("closed"), 0.5 * rmse_m("open"));
}

}  // namespace
}  // namespace scanknit
