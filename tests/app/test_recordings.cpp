// The main job on real recordings of ../shared/data (or SCANKNIT_TEST_DATA); skipped where they are not.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Recording {
  const char* name;    ///< of the test
  const char* folder;  ///< in the data
  std::vector<std::string> arguments;
  int frames;                    ///< that must be fused
  std::size_t triangles;         ///< at least; about half of what came out when this was written
  double smallest_m, largest_m;  ///< bounds of the mesh's longest side
};

std::ostream& operator<<(std::ostream& out, const Recording& recording) {
  return out << recording.name;
}

class RealRecording : public ::testing::TestWithParam<Recording> {};

TEST_P(RealRecording, BecomesAMesh) {
  const Recording& recording = GetParam();
  const fs::path folder = test::data_folder() / recording.folder;
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no recording at " << folder;
  const TempFolder out;
  std::vector<std::string> arguments = {"run", folder.string(), "-o", out.path().string(), "--json"};
  arguments.insert(arguments.end(), recording.arguments.begin(), recording.arguments.end());
  const Outcome outcome = scanknit_command(arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;

  const Json report = Json::parse(outcome.out, nullptr, false);
  ASSERT_TRUE(report.is_object());
  const Json& mesh = report["mesh"];
  EXPECT_EQ(report["frames"]["fused"], recording.frames);
  EXPECT_GT(mesh["triangles"].get<std::size_t>(), recording.triangles);
  EXPECT_EQ(mesh["non_manifold_edges"], 0);
  EXPECT_EQ(mesh["non_manifold_vertices"], 0);
  double longest_m = 0;
  for (int axis = 0; axis < 3; ++axis) {
    longest_m = std::max(longest_m, mesh["bounds_m"][1][axis].get<double>() - mesh["bounds_m"][0][axis].get<double>());
  }
  EXPECT_GT(longest_m, recording.smallest_m);
  EXPECT_LT(longest_m, recording.largest_m);
  for (const char* name : {"model.glb", "model.ply", "preview.png", "report.json", "trajectory.txt"}) {
    EXPECT_TRUE(fs::exists(out / name)) << name;
  }
}

struct TrackedRecording {
  const char* name;
  const char* folder;
  const char* voxel_size;
  double rmse_m;  ///< at most, from the recorded poses, which are estimates themselves (../shared/data/README.md)
  std::vector<std::string> camera = {};  ///< settings, where the recording does not say it
};

std::ostream& operator<<(std::ostream& out, const TrackedRecording& recording) {
  return out << recording.name;
}

class Tracked : public ::testing::TestWithParam<TrackedRecording> {};

TEST_P(Tracked, FollowsTheRecordedPoses) {
  const TrackedRecording& recording = GetParam();
  const fs::path folder = test::data_folder() / recording.folder;
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no recording at " << folder;
  const TempFolder out;
  const auto run = [&](const std::string& poses) {
    std::vector<std::string> arguments = {"run",          folder.string(),
                                          "-o",           out / (poses + ".ply"),
                                          "--trajectory", out / (poses + ".txt"),
                                          "--poses",      poses,
                                          "--set",        std::string("fusion.voxel_size=") + recording.voxel_size,
                                          "--json"};
    for (const std::string& setting : recording.camera) arguments.insert(arguments.end(), {"--set", setting});
    const Outcome outcome = scanknit_command(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  };
  (void)run("recording");
  EXPECT_EQ(run("track")["frames"]["lost"], 0);
  const TrajectoryError error = trajectory_error(out / "track.txt", out / "recording.txt");
  std::cout << recording.name << ", tracked: ATE RMSE " << 1000 * error.rmse_m << " mm against the recorded poses\n";
  EXPECT_EQ(error.pairs, error.estimated);
  EXPECT_LE(error.rmse_m, recording.rmse_m);
}

INSTANTIATE_TEST_SUITE_P(Main, Tracked,
                         ::testing::Values(TrackedRecording{"box_f200", "rgbd_box_f200", "2mm", 0.0025},
                                           TrackedRecording{"redwood", "rgbd_redwood_lr1_211", "1cm", 0.02},
                                           TrackedRecording{"tum_rpy", "rgbd_tum_fr1_rpy_150", "1cm", 0.02},
                                           TrackedRecording{"shelf",
                                                            "rgbd_shelf_masks_15",
                                                            "3mm",
                                                            0.006,
                                                            {"acquire.intrinsics=[611.355,611.4,337.406,247.190]",
                                                             "acquire.depth_scale=10000"}}),
                         [](const auto& test) { return std::string(test.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Main, RealRecording,
    ::testing::Values(
        Recording{"box_f200", "rgbd_box_f200", {"--set", "fusion.voxel_size=2mm"}, 50, 50'000, 0.3, 3},
        Recording{
            "phone_corridor", "rgbd_iphone_lidar_corridor_73", {"--set", "fusion.voxel_size=3cm"}, 73, 20'000, 10, 60},
        Recording{"redwood", "rgbd_redwood_lr1_211", {"--set", "fusion.voxel_size=1cm"}, 211, 200'000, 3, 12},
        Recording{
            "icl", "rgbd_icl_3/dataset", {"--preset", "icl_nuim", "--set", "fusion.voxel_size=1cm"}, 3, 20'000, 1, 10},
        Recording{"sun3d", "rgbd_sun3d_studyroom_5/3dmatch", {"--set", "fusion.voxel_size=1cm"}, 5, 10'000, 1, 12}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace scanknit
