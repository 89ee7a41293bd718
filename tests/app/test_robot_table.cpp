// A D435i on a robot's arm before a table in an open hall, at 2 mm and with nothing else said: the hall is not scanned,
// the table is, and the path is the arm's. In ../shared/data (or SCANKNIT_TEST_DATA); skipped where it is not.
#include <gtest/gtest.h>

#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/hand_eye.h"
#include "tests/app/program.h"
#include "tests/app/trajectory_error.h"
#include "tests/support/places.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using PosesByFrame = std::map<int, Eigen::Isometry3d>;

PosesByFrame arm_poses(const fs::path& path) {
  PosesByFrame poses;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    int frame = 0;
    if (!(numbers >> frame)) continue;
    Eigen::Matrix4d matrix;
    for (int i = 0; i < 16; ++i) numbers >> matrix(i / 4, i % 4);
    poses[frame] = Eigen::Isometry3d(matrix);
  }
  return poses;
}

PosesByFrame tracked_poses(const fs::path& path) {
  PosesByFrame poses;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    double stamp = 0;
    Eigen::Vector3d t;
    Eigen::Quaterniond q;
    if (!(numbers >> stamp >> t.x() >> t.y() >> t.z() >> q.x() >> q.y() >> q.z() >> q.w())) continue;
    poses[static_cast<int>(stamp)] = Eigen::Translation3d(t) * q.normalized();
  }
  return poses;
}

/// Where the arm had the camera, by the hand-eye transform that fits `camera` best.
void write_arm_path(const PosesByFrame& hand, const PosesByFrame& camera, const fs::path& path) {
  Poses hands, cameras;
  for (const auto& [frame, pose] : camera) {
    if (!hand.contains(frame)) continue;
    hands.push_back(hand.at(frame));
    cameras.push_back(pose);
  }
  const Eigen::Isometry3d T_hand_camera = hand_eye(hands, cameras);
  std::ofstream file(path);
  for (const auto& [frame, pose] : hand) {
    const Eigen::Vector3d t = (pose * T_hand_camera).translation();
    file << frame << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << " 0 0 0 1\n";
  }
}

TEST(HandEye, IsFoundFromExactPoses) {
  const auto pose = [](double x, double y, double z) {
    Eigen::Isometry3d T(Eigen::Translation3d(y, z, x));
    T.rotate(Eigen::AngleAxisd(x, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()) *
             Eigen::AngleAxisd(z, Eigen::Vector3d::UnitZ()));
    return T;
  };
  const Eigen::Isometry3d T_hand_camera = pose(0.3, -0.2, 0.1), T_world_base = pose(1, 2, -1);
  Poses hands, cameras;
  for (int i = 0; i < 6; ++i) {
    hands.push_back(pose(0.2 * i, 0.1 * i * i, -0.3 * i));
    cameras.push_back(T_world_base * hands.back() * T_hand_camera);
  }
  EXPECT_TRUE(hand_eye(hands, cameras).isApprox(T_hand_camera, 1e-9));
}

TEST(RobotTable, IsScannedWholeAndWithoutTheHallBehindIt) {
  const fs::path folder = test::data_folder() / "rgbd_d435i_table_48";
  if (!fs::exists(folder)) GTEST_SKIP() << "SKIPPED: no recording at " << folder;
  const TempFolder out;
  const Outcome outcome =
      scanknit_command({"run", folder.string(), "-o", out.path().string(), "--set", "fusion.voxel_size=2mm", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("sensor: realsense_d400"), std::string::npos) << outcome.err;
  const Json report = Json::parse(outcome.out, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["frames"]["fused"], 48);
  EXPECT_EQ(report["config"]["acquire"]["sensor"], "realsense_d400");
  EXPECT_LE(report["mesh"]["components"].get<int>(), 10);
  EXPECT_LE(report["peak_rss_mib"].get<double>(), 1536);
  for (int axis = 0; axis < 3; ++axis) {
    const Json& bounds = report["mesh"]["bounds_m"];
    EXPECT_LE(bounds[1][axis].get<double>() - bounds[0][axis].get<double>(), 3.0) << "axis " << axis;
  }
  write_arm_path(arm_poses(folder / "robot_T_base_ee.txt"), tracked_poses(out / "trajectory.txt"), out / "arm.txt");
  const TrajectoryError error = trajectory_error(out / "trajectory.txt", out / "arm.txt");
  std::cout << "path: " << 1000 * error.rmse_m << " mm RMSE from the arm's, " << report["mesh"]["components"]
            << " pieces\n";
  EXPECT_EQ(error.pairs, 48u);
  EXPECT_LE(error.rmse_m, 0.001);
}

}  // namespace
}  // namespace scanknit
