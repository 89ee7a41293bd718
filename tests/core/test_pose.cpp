#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "core/pose.h"

namespace scanknit {
namespace {

constexpr double kExact = 1e-12;  // a few roundings of double

Pose turned(double angle_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  return pose;
}

TEST(PoseFromMatrix, TakesARigidMatrix) {
  const Pose pose = turned(0.7);
  const auto read = pose_from_matrix(pose.matrix());
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->isApprox(pose, kExact));
}

TEST(PoseFromMatrix, RemovesTheRoundingOfPrintedDigits) {
  Eigen::Matrix4d printed = turned(0.7).matrix();
  printed.topLeftCorner<3, 3>() = (printed.topLeftCorner<3, 3>() * 1000).array().round() / 1000;
  const auto read = pose_from_matrix(printed);
  ASSERT_TRUE(read);
  EXPECT_TRUE(is_rigid(*read));
}

TEST(PoseFromMatrix, RefusesNaNAndInfinity) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 3) = std::numeric_limits<double>::quiet_NaN();
  const auto nan = pose_from_matrix(matrix);
  ASSERT_FALSE(nan);
  EXPECT_EQ(nan.error().code, ErrorCode::kInput);
  matrix(0, 3) = -std::numeric_limits<double>::infinity();  // how some recordings say "tracking lost"
  EXPECT_FALSE(pose_from_matrix(matrix));
}

TEST(PoseFromMatrix, RefusesAPlaceThatCannotBe) {
  Eigen::Matrix4d matrix = turned(0.7).matrix();
  matrix(1, 3) = -1.7e308;  // finite, but the inverse is not
  EXPECT_FALSE(pose_from_matrix(matrix));
}

TEST(PoseFromMatrix, RefusesScaleAndShear) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = 1.1;
  EXPECT_FALSE(pose_from_matrix(matrix));
  matrix = Eigen::Matrix4d::Identity();
  matrix(0, 1) = 0.1;
  EXPECT_FALSE(pose_from_matrix(matrix));
  EXPECT_FALSE(pose_from_matrix(Eigen::Matrix4d::Zero()));
}

TEST(PoseFromMatrix, RefusesAMirror) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(2, 2) = -1;
  const auto read = pose_from_matrix(matrix);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("mirrors"), std::string::npos);
}

TEST(PoseFromMatrix, RefusesAnotherLastRow) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(3, 0) = 1;
  EXPECT_FALSE(pose_from_matrix(matrix));
}

TEST(Interpolate, EndsAtBothPoses) {
  const Pose a = turned(0.2), b = turned(1.0);
  EXPECT_TRUE(interpolate(a, b, 0).isApprox(a, kExact));
  EXPECT_TRUE(interpolate(a, b, 1).isApprox(b, kExact));
}

TEST(Interpolate, HalfWayIsHalfTheTurn) {
  const Pose half = interpolate(turned(0.2), turned(1.0), 0.5);
  EXPECT_TRUE(half.linear().isApprox(turned(0.6).linear(), kExact));
}

TEST(Interpolate, TakesTheShorterWayRound) {
  const Pose half = interpolate(turned(0.1), turned(2 * std::numbers::pi - 0.1), 0.5);
  EXPECT_TRUE(half.linear().isApprox(Eigen::Matrix3d::Identity(), 1e-9));
}

TEST(IsRigid, SeesScaleAndNaN) {
  Pose pose = turned(0.4);
  EXPECT_TRUE(is_rigid(pose));
  pose.linear() *= 1.001;
  EXPECT_FALSE(is_rigid(pose));
  pose = turned(0.4);
  pose.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_rigid(pose));
}

}  // namespace
}  // namespace scanknit
