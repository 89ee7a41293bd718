// Recordings without poses: tracked, lost and found again, by the built program.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kVoxel_m = 0.02;
constexpr int kFrames = 120;  // 3 degrees and 5 cm from frame to frame

/// An orbit of the desk in small pictures. The true poses are kept aside: the recording itself has none.
class Orbit : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    original_ = new TempFolder;
    const std::string recording = *original_ / "recording";
    const Outcome synth = scanknit_command({"synth", "desk", "-o", recording, "--frames", std::to_string(kFrames),
                                            "--width", "160", "--height", "120", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    const Outcome run = scanknit_command({"run", recording, "-o", *original_ / "true.ply", "--trajectory",
                                          truth().string(), "--set", "fusion.voxel_size=2cm", "--quiet"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    fs::rename(*original_ / "recording/trajectory.log", *original_ / "trajectory.log");
  }
  static void TearDownTestSuite() {
    delete original_;
    original_ = nullptr;
  }
  void SetUp() override { fs::copy(*original_ / "recording", recording(), fs::copy_options::recursive); }

  [[nodiscard]] static fs::path truth() { return *original_ / "truth.txt"; }
  [[nodiscard]] fs::path recording() const { return folder_ / "recording"; }
  [[nodiscard]] fs::path output() const { return folder_ / "out"; }

  void cover_lens(int from, int to) const {
    for (int frame = from; frame <= to; ++frame) {
      ASSERT_TRUE(cv::imwrite(depth_file(frame).string(), cv::Mat::zeros(120, 160, CV_16UC1)));
    }
  }
  /// Shows at `frame` what was seen at `earlier`.
  void repeat(int earlier, int frame) const {
    fs::copy_file(depth_file(earlier), depth_file(frame), fs::copy_options::overwrite_existing);
    fs::copy_file(picture("color", earlier), picture("color", frame), fs::copy_options::overwrite_existing);
  }
  void cut(int from, int to) const {
    for (int frame = from; frame <= to; ++frame) {
      fs::remove(depth_file(frame));
      fs::remove(picture("color", frame));
    }
  }
  /// Gives the recording the true poses without those of some frames.
  void cut_poses(int from, int to) const {
    constexpr int kLines = 5;  // of a pose
    std::ifstream all(truth().parent_path() / "trajectory.log");
    std::ofstream rest(recording() / "trajectory.log");
    std::string line;
    for (int i = 0; std::getline(all, line); ++i) {
      if (i / kLines < from || i / kLines > to) rest << line << '\n';
    }
  }

  [[nodiscard]] Outcome run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run",   recording().string(),    "-o",     output().string(),
                                          "--set", "fusion.voxel_size=2cm", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }
  /// How far the mesh is from the scene.
  [[nodiscard]] Json distance() const {
    return Json::parse(
        scanknit_command({"distance", (output() / "model.ply").string(), recording().string(), "--json"}).out, nullptr,
        false);
  }
  [[nodiscard]] Json report() const { return Json::parse(read_text(output() / "report.json"), nullptr, false); }
  /// The world is the first camera's, so the truth is compared after alignment.
  [[nodiscard]] TrajectoryError error() const { return trajectory_error(output() / "trajectory.txt", truth()); }

 private:
  [[nodiscard]] fs::path picture(const std::string& kind, int frame) const {
    std::string name = std::to_string(frame);
    name.insert(0, 6 - name.size(), '0');
    return recording() / kind / (name + ".png");
  }
  [[nodiscard]] fs::path depth_file(int frame) const { return picture("depth", frame); }

  static TempFolder* original_;
  TempFolder folder_;
};

TempFolder* Orbit::original_ = nullptr;

TEST_F(Orbit, WithoutPosesIsTrackedAllTheWayRound) {
  const Outcome outcome = run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json tracking = report()["tracking"];
  EXPECT_EQ(tracking["mode"], "track");
  EXPECT_EQ(tracking["states"]["ok"], kFrames);
  EXPECT_EQ(tracking["frames"].size(), static_cast<std::size_t>(kFrames));
  EXPECT_GT(tracking["frames"][60]["inlier_share"].get<double>(), 0.6);
  EXPECT_GT(report()["stages"]["raycast"]["total_ms"].get<double>(), 0);
  EXPECT_EQ(error().pairs, static_cast<std::size_t>(kFrames));
  EXPECT_LT(error().rmse_m, kVoxel_m / 4);
}

TEST_F(Orbit, WithPosesIsTrackedInTheWorldOfTheFirst) {
  fs::copy(truth().parent_path() / "trajectory.log", recording());
  const Outcome outcome = run({"--poses", "track"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LT(error().unaligned_rmse_m, kVoxel_m / 4);
  ASSERT_EQ(run().exit_code, 0);  // auto: as recorded
  EXPECT_TRUE(report()["tracking"].is_null());
  EXPECT_LT(error().unaligned_rmse_m, 1e-6);
}

TEST_F(Orbit, IsRefinedRoundItsRecordedPoses) {
  fs::copy(truth().parent_path() / "trajectory.log", recording());
  const Outcome outcome = run({"--poses", "refine"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(report()["tracking"]["mode"], "refine");
  EXPECT_EQ(report()["frames"]["fused"], kFrames);
  EXPECT_LT(error().unaligned_rmse_m, kVoxel_m / 4);
}

TEST_F(Orbit, UnderACoveredLensIsLostFusesNothingAndGoesOn) {
  cover_lens(40, 44);
  const Outcome outcome = run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json tracking = report()["tracking"];
  for (std::size_t frame = 40; frame <= 44; ++frame) {
    EXPECT_EQ(tracking["frames"][frame]["state"], "lost");
    EXPECT_EQ(tracking["frames"][frame]["reason"], "nothing seen");
  }
  EXPECT_EQ(tracking["frames"][45]["state"], "recovered");
  EXPECT_EQ(report()["frames"]["lost"], 5);
  EXPECT_EQ(report()["frames"]["fused"], kFrames - 5);
  EXPECT_EQ(error().estimated, static_cast<std::size_t>(kFrames - 5));  // lost frames are left out
  EXPECT_LT(error().rmse_m, kVoxel_m / 4);
}

TEST_F(Orbit, WithFortyFramesCutOutMakesNoSecondCopy) {
  cut(40, 79);
  const Outcome outcome = run();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json tracking = report()["tracking"];
  EXPECT_EQ(tracking["frames"][40]["state"], "recovered");  // lost at first: nothing that it shows was known
  EXPECT_EQ(tracking["frames"][40]["reason"], "found later");
  EXPECT_GT(tracking["found_later"].get<int>(), 0);
  EXPECT_EQ(report()["frames"]["lost"], 0);
  EXPECT_EQ(report()["frames"]["fused"], kFrames - 40);
  EXPECT_EQ(error().estimated, static_cast<std::size_t>(kFrames - 40));
  EXPECT_LT(error().max_m, kVoxel_m);  // a frame fused in a wrong place would be far off
}

TEST_F(Orbit, WithFortyFramesCutOutHasItsSurfaceWhereTheSceneIs) {
  cut_poses(40, 79);
  cut(40, 79);
  const Outcome outcome = run({"--poses", "track"});  // in the world of the truth
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json cut_error = distance();
  EXPECT_LT(cut_error["area"]["p95_m"].get<double>(), kVoxel_m);  // a second copy would be farther off
  EXPECT_LT(cut_error["area"]["mean_m"].get<double>(), kVoxel_m / 4);
}

TEST_F(Orbit, ThatIsFoundAgainAfterMostOfItsLengthIsMeshedWithAWarning) {
  cover_lens(10, 114);
  for (int frame = 115; frame < kFrames; ++frame) repeat(frame - 110, frame);  // back to where it began
  const Outcome outcome = run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  ASSERT_EQ(report()["warnings"].size(), 1u);
  const auto warning = report()["warnings"][0].get<std::string>();
  EXPECT_NE(warning.find("and found again: the mesh holds only"), std::string::npos) << warning;
  EXPECT_GT(report()["frames"]["lost"], 60);
  EXPECT_GT(report()["mesh"]["triangles"], 0);
}

TEST_F(Orbit, ThatIsLostForMostOfItsLengthIsRefusedAndKeepsItsVolume) {
  cover_lens(20, kFrames - 1);
  const Outcome outcome = run({"--save-volume", output() / "volume.vdb"});
  EXPECT_NE(outcome.err.find("No mesh is made of the 20 fused frames"), std::string::npos) << outcome.err;
  EXPECT_TRUE(fs::exists(output() / "volume.vdb"));
  EXPECT_TRUE(fs::exists(output() / "trajectory.txt"));
  EXPECT_EQ(outcome.exit_code, 6);
  EXPECT_NE(outcome.err.find("tracking was lost in 100 of 120 frames"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("nothing seen"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(output() / "model.ply"));
  EXPECT_EQ(report()["exit_code"], 6);
  EXPECT_EQ(report()["frames"]["lost"], 100);
}

TEST_F(Orbit, ThatLeavesAFullVolumeIsMeshedAsFarAsItGoesAndBlamesTheBudget) {
  const Outcome outcome = run({"--set", "fusion.memory_budget=8MiB", "--set", "fusion.voxel_size=5mm"});
  EXPECT_EQ(outcome.exit_code, 9) << outcome.err;
  EXPECT_NE(outcome.err.find("fusion.memory_budget"), std::string::npos) << outcome.err;
  EXPECT_TRUE(fs::exists(output() / "model.glb"));
  EXPECT_EQ(report()["exit_code"], 9);
  EXPECT_NE(report()["status"].get<std::string>().find("fusion.memory_budget"), std::string::npos);
  EXPECT_EQ(report()["volume"]["is_budget_reached"], true);
  EXPECT_LE(report()["volume"]["memory_mib"].get<double>(), 8);
  EXPECT_GT(report()["mesh"]["triangles"].get<int>(), 0);
  EXPECT_GT(report()["frames"]["lost"].get<int>(), kFrames / 2);
}

TEST_F(Orbit, GivesTheSameTrajectoryAndMeshForAnyNumberOfThreads) {
  std::vector<std::string> trajectories, meshes;
  for (const char* threads : {"1", "2", "8"}) {
    ASSERT_EQ(run({"--threads", threads, "--to", "30"}).exit_code, 0);
    trajectories.push_back(read_text(output() / "trajectory.txt"));
    meshes.push_back(read_text(output() / "model.ply"));
  }
  EXPECT_FALSE(trajectories[0].empty());
  EXPECT_EQ(trajectories[1], trajectories[0]);
  EXPECT_EQ(trajectories[2], trajectories[0]);
  EXPECT_EQ(meshes[1], meshes[0]);
  EXPECT_EQ(meshes[2], meshes[0]);
}

}  // namespace
}  // namespace scanknit
