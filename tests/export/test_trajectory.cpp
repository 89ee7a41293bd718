#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <sstream>

#include "export/trajectory.h"

namespace scanknit {
namespace {

constexpr double kPromised = 1e-9;

Pose pose_at(double angle_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(12.345678901234, -1.0 / 3, 1e-5);
  return pose;
}

TEST(TumTrajectory, GivesEveryPoseBack) {
  for (const double angle_rad : {0.0, 0.5, 2.0, 3.1415, 4.0, 6.0}) {
    std::istringstream line(to_tum_trajectory({{1305031102.175304, pose_at(angle_rad)}}));
    double stamp, tx, ty, tz, qx, qy, qz, qw;
    ASSERT_TRUE(line >> stamp >> tx >> ty >> tz >> qx >> qy >> qz >> qw);
    EXPECT_EQ(stamp, 1305031102.175304);
    EXPECT_NEAR((Eigen::Vector3d(tx, ty, tz) - pose_at(angle_rad).translation()).norm(), 0, kPromised);
    const Eigen::Matrix3d rotation = Eigen::Quaterniond(qw, qx, qy, qz).toRotationMatrix();
    EXPECT_NEAR((rotation - pose_at(angle_rad).linear()).cwiseAbs().maxCoeff(), 0, kPromised);
    EXPECT_GE(qw, 0);
  }
}

TEST(TumTrajectory, IsOneLineAPose) {
  const std::string text = to_tum_trajectory({{1, Pose::Identity()}, {2, Pose::Identity()}});
  EXPECT_EQ(text, "1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
}

TEST(TumTrajectory, WithoutPosesIsEmpty) {
  EXPECT_EQ(to_tum_trajectory({}), "");
}

TEST(KittiTrajectory, HoldsTheUpperThreeRows) {
  std::istringstream line(to_kitti_trajectory({{7, pose_at(2.0)}}));
  for (int i = 0; i < 12; ++i) {
    double number = 0;
    ASSERT_TRUE(line >> number);
    EXPECT_EQ(number, pose_at(2.0).matrix()(i / 4, i % 4));
  }
  EXPECT_EQ(to_kitti_trajectory({{1, Pose::Identity()}, {2, Pose::Identity()}}),
            "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
}

TEST(JsonTrajectory, GivesEveryPoseBack) {
  const auto json = nlohmann::json::parse(to_json_trajectory({{0.25, pose_at(2.0)}, {3, pose_at(4.0)}}, "a \"note\""));
  EXPECT_EQ(json.at("note"), "a \"note\"");
  ASSERT_EQ(json.at("poses").size(), 2u);
  EXPECT_EQ(json["poses"][0].at("stamp"), 0.25);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(json["poses"][1].at("T_world_camera").at(i / 4).at(i % 4), pose_at(4.0).matrix()(i / 4, i % 4));
  }
  EXPECT_EQ(nlohmann::json::parse(to_json_trajectory({})).at("poses").size(), 0u);
}

TEST(TrajectoryText, GoesByTheEnding) {
  const std::vector<StampedPose> poses = {{1, Pose::Identity()}};
  EXPECT_EQ(trajectory_text("a.txt", poses, "of a scan"), "# of a scan\n1 0 0 0 0 0 0 1\n");
  EXPECT_EQ(trajectory_text("a.kitti", poses, "of a scan"), to_kitti_trajectory(poses));
  EXPECT_EQ(trajectory_text("a.json", poses, "of a scan"), to_json_trajectory(poses, "of a scan"));
}

}  // namespace
}  // namespace scanknit
