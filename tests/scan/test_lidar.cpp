// From LiDAR sweeps to a mesh: a room of planes.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/median.h"
#include "export/mesh/read_mesh.h"
#include "scan/scan.h"
#include "tests/acquire/lidar_bag.h"
#include "tests/acquire/lidar_room.h"
#include "tests/core/temporary_folder.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using namespace test;

class LidarRoom : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path sequence() const { return folder_.path() / "sequences" / "07"; }
  [[nodiscard]] fs::path mesh() const { return folder_.path() / "out" / "model.ply"; }
  [[nodiscard]] ScanJob job() const {
    ScanJob job;
    job.input = sequence();
    job.files.meshes = {mesh()};
    job.files.trajectory = folder_.path() / "out" / "trajectory.txt";
    return job;
  }
  [[nodiscard]] static ScanResult scanned(const ScanJob& job) {
    ScanObserver nobody;
    return scan_recording(job, nobody);
  }
  [[nodiscard]] std::string bytes_of_mesh() const {
    std::ifstream file(mesh(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// The distance of each vertex to the nearest wall, ascending. A mesh of KITTI's is in the camera's world.
  [[nodiscard]] std::vector<double> errors_m(const Pose& T_room_world = kitti_camera_of_sensor().inverse()) const {
    const auto read = read_mesh(mesh(), {});
    EXPECT_TRUE(read);
    std::vector<double> errors;
    for (const Eigen::Vector3f& p : read->positions_m) errors.push_back(off_walls_m(T_room_world * p.cast<double>()));
    std::sort(errors.begin(), errors.end());
    return errors;
  }

  test::TemporaryFolder folder_;
};

TEST_F(LidarRoom, BecomesItsWalls) {
  write_kitti_room(sequence(), 12);
  const ScanResult result = scanned(job());
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.fused, 12u);
  EXPECT_EQ(result.trajectory.size(), 12u);
  EXPECT_DOUBLE_EQ(result.trajectory[3].stamp, 0.3) << "of times.txt";
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front().text;
  const double voxel_m = result.config.fusion.voxel_size_m;
  EXPECT_GE(voxel_m, 0.02);
  EXPECT_LE(voxel_m, 0.2);
  const std::vector<double> errors = errors_m();
  ASSERT_GT(errors.size(), 1000u);
  EXPECT_LT(errors[errors.size() / 2], 0.02 * voxel_m) << "planes have no curvature to smooth away";
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.3 * voxel_m) << "but where walls meet";
  EXPECT_LT(errors.back(), 2 * voxel_m);
  ASSERT_TRUE(result.mesh.check);
  const Eigen::Vector3f size = result.mesh.check->max_m - result.mesh.check->min_m;
  EXPECT_GT(size.maxCoeff(), 11.5F) << "the room is 12 m long";
}

TEST_F(LidarRoom, BecomesItsWallsInABagOfAMovingScanner) {
  LidarWalk walk;
  walk.model = {};
  walk.sweeps = 30;
  const Bytes bag = walk.bag().file();
  const fs::path file = folder_.path() / "walk.mcap";
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bag.data()), static_cast<std::streamsize>(bag.size()));
  ScanJob asked = job();
  asked.input = file;
  asked.config.acquire.every = 3;
  const ScanResult result = scanned(asked);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.fused, 10u);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front().text;
  const double voxel_m = result.config.fusion.voxel_size_m;
  const std::vector<double> errors = errors_m(Pose::Identity());
  ASSERT_GT(errors.size(), 1000u);
  EXPECT_LT(errors[errors.size() / 2], 0.02 * voxel_m) << "of the motion within a sweep nothing is left";
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.3 * voxel_m) << "but where walls meet";
}

TEST_F(LidarRoom, NeedsTheCalibrationOfTheSensor) {
  write_kitti_room(sequence(), 4);
  std::ofstream(sequence() / "calib.txt") << "P0: 1 2 3\n";
  const ScanResult result = scanned(job());
  ASSERT_FALSE(result.outcome);
  EXPECT_EQ(result.outcome.error().code, ErrorCode::kInput);
  EXPECT_NE(result.outcome.error().text().find("Tr"), std::string::npos) << result.outcome.error().text();
}

TEST_F(LidarRoom, HasThePosesThatTheBenchmarkKeepsApart) {
  write_kitti_room(sequence(), 3);
  fs::create_directories(folder_.path() / "poses");
  fs::rename(sequence() / "poses.txt", folder_.path() / "poses" / "07.txt");
  EXPECT_TRUE(scanned(job()).outcome);
}

TEST_F(LidarRoom, WithoutPosesSaysWhatIsExpected) {
  write_kitti_room(sequence(), 3);
  fs::remove(sequence() / "poses.txt");
  const ScanResult result = scanned(job());
  ASSERT_FALSE(result.outcome);
  EXPECT_EQ(result.outcome.error().code, ErrorCode::kInput);
  EXPECT_NE(result.outcome.error().message.find("poses.txt"), std::string::npos);
  EXPECT_FALSE(fs::exists(mesh()));
}

TEST_F(LidarRoom, DropsSweepsThatCannotBeUsed) {
  write_kitti_room(sequence(), 6);
  fs::resize_file(sequence() / "velodyne" / "000002.bin", 1001);
  std::ofstream(sequence() / "velodyne" / "000006.bin");  // no line of poses, and empty
  ScanJob asked = job();
  asked.config.fusion.voxel_size_m = 0.2;
  asked.asked_keys = {"fusion.voxel_size"};
  const ScanResult result = scanned(asked);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.read, 7u);
  EXPECT_EQ(result.frames.fused, 5u);
  EXPECT_EQ(result.frames.dropped, 2u);
  EXPECT_EQ(result.frames.dropped_by_reason.at("unreadable"), 1u);
  EXPECT_EQ(result.frames.dropped_by_reason.at("bad_pose"), 1u);
  EXPECT_NE(find_warning(result, WarningCode::kFramesDropped), nullptr);
}

TEST_F(LidarRoom, SelectsSweepsAndRange) {
  write_kitti_room(sequence(), 6);
  ScanJob asked = job();
  asked.config.acquire.from = 1;
  asked.config.acquire.every = 2;
  asked.config.acquire.max_depth_m = 4.5;
  const ScanResult result = scanned(asked);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  ASSERT_EQ(result.trajectory.size(), 3u);
  EXPECT_EQ(result.trajectory[2].sequence, 5u);
  const auto read = read_mesh(mesh(), {});
  ASSERT_TRUE(read);
  const double band_m = 5 * result.config.fusion.voxel_size_m;
  for (const Eigen::Vector3f& p : read->positions_m) {
    const bool is_near = std::any_of(result.trajectory.begin(), result.trajectory.end(), [&](const PosedFrame& frame) {
      return (p.cast<double>() - frame.T_world_camera.translation()).norm() < 4.5 + band_m;
    });
    ASSERT_TRUE(is_near) << p.transpose();
  }
}

TEST_F(LidarRoom, IsTheSameForAnyNumberOfThreads) {
  write_kitti_room(sequence(), 3);
  std::vector<std::string> meshes;
  for (const std::size_t threads : {std::size_t{1}, std::size_t{4}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    ASSERT_TRUE(scanned(job()).outcome);
    meshes.push_back(bytes_of_mesh());
  }
  EXPECT_FALSE(meshes[0].empty());
  EXPECT_TRUE(meshes[0] == meshes[1]);
}

TEST_F(LidarRoom, StaysWithinItsBudget) {
  write_kitti_room(sequence(), 12);
  ScanJob asked = job();
  asked.config.fusion.voxel_size_m = 0.03;
  asked.config.fusion.memory_budget_mib = kLeastMemoryBudgetMib;
  asked.asked_keys = {"fusion.voxel_size"};
  const ScanResult result = scanned(asked);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_NE(find_warning(result, WarningCode::kBudgetReached), nullptr);
  EXPECT_LT(result.frames.fused, 12u);
}

TEST_F(LidarRoom, RefusesToTrackSweeps) {
  write_kitti_room(sequence(), 2);
  ScanJob asked = job();
  asked.config.acquire.poses = PoseMode::kTrack;
  EXPECT_EQ(scanned(asked).outcome.error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace scanknit
