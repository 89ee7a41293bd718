// Where a robot's frames of reference are: links that move, that are slow, or that never change.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdint>

#include "acquire/ros2/transform_tree.h"

namespace scanknit::test {
namespace {

TEST(TransformTree, ThatIsACircleEnds) {
  TransformTree tree;
  const auto add = [&](const char* parent, const char* child) {
    tree.add({0, parent, child, Pose(Eigen::Translation3d(1, 0, 0))}, true);
  };
  add("a", "b");
  add("b", "c");
  add("c", "a");
  tree.sort();
  EXPECT_FALSE(tree.root_of("b").empty());
  EXPECT_TRUE(tree.pose_in_root("b", 0));
  EXPECT_TRUE(tree.between("a", "c"));
}

TEST(TransformTree, LeadsOverTheCommonParent) {
  TransformTree tree;
  tree.add({0, "base", "left", Pose(Eigen::Translation3d(0, 1, 0))}, true);
  tree.add({0, "base", "right", Pose(Eigen::Translation3d(0, -1, 0))}, true);
  tree.add({0, "map", "base", Pose(Eigen::Translation3d(9, 9, 9))}, false);
  tree.sort();
  EXPECT_TRUE(tree.between("left", "right")->translation().isApprox(Eigen::Vector3d(0, -2, 0)));
  EXPECT_FALSE(tree.between("left", "map")) << "the robot moves";
  EXPECT_TRUE(tree.is_moving("left"));
  EXPECT_FALSE(tree.is_moving("map"));
}

constexpr std::int64_t kOneSecond_ns = 1'000'000'000;

/// A map's correction once a second, odometry fifty times a second, a mount that is told ten times a second.
TransformTree robot_with_map(double correction_m) {
  TransformTree tree;
  for (int k = 0; k <= 500; ++k) {
    const std::int64_t time_ns = k * kOneSecond_ns / 50;
    const Pose at(Eigen::Translation3d(k * 0.01, 0, 0));
    tree.add({time_ns, "odom", "base", at}, false);
    if (k % 50 == 0) tree.add({time_ns, "map", "odom", Pose(Eigen::Translation3d(0, k * correction_m / 50, 0))}, false);
    if (k % 5 == 0) tree.add({time_ns, "base", "camera", Pose(Eigen::Translation3d(0, 0, 1))}, false);
  }
  tree.sort();
  return tree;
}

TEST(TransformTree, InterpolatesSlowCorrectionsAsTf2Does) {
  const TransformTree tree = robot_with_map(0.1);
  const auto pose = tree.pose_in_root("camera", kOneSecond_ns * 21 / 4);
  ASSERT_TRUE(pose && *pose);
  EXPECT_TRUE((*pose)->translation().isApprox(Eigen::Vector3d(2.625, 0.525, 1))) << (*pose)->translation();
}

TEST(TransformTree, HoldsWhatNeverChangesAtAllTimes) {
  TransformTree tree;
  for (int k = 0; k < 3; ++k)
    tree.add({k * kOneSecond_ns, "world", "camera", Pose(Eigen::Translation3d(1, 2, 3))}, false);
  tree.sort();
  EXPECT_TRUE(tree.is_moving("camera")) << "its poses are wanted all the same";
  for (const double second : {-5.0, 0.5, 60.0}) {
    const auto pose = tree.pose_in_root("camera", static_cast<std::int64_t>(second * 1e9));
    ASSERT_TRUE(pose && *pose) << second;
    EXPECT_TRUE((*pose)->translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  }
  EXPECT_TRUE(tree.between("world", "camera"));
}

TEST(TransformTree, FollowsWhatMovesOnlyWhereItIsToldOften) {
  TransformTree tree;
  for (int k = 0; k < 10; ++k) {
    tree.add({k * kOneSecond_ns / 5, "world", "camera", Pose(Eigen::Translation3d(k * 0.1, 0, 0))}, false);
  }
  tree.sort();
  EXPECT_FALSE(tree.pose_in_root("camera", kOneSecond_ns / 10)) << "five times a second is not enough";
  EXPECT_TRUE(tree.pose_in_root("camera", kOneSecond_ns / 5));
  const TransformTree with_map = robot_with_map(0.1);
  EXPECT_TRUE(with_map.pose_in_root("camera", kOneSecond_ns * 10)) << "the end of all";
  EXPECT_FALSE(with_map.pose_in_root("camera", kOneSecond_ns * 21 / 2)) << "odometry has ended";
}

TEST(TransformTree, HoldsSlowCorrectionsForASecondBeyondTheirEnds) {
  TransformTree tree;
  tree.add({2 * kOneSecond_ns, "map", "odom", Pose(Eigen::Translation3d(0, 1, 0))}, false);
  tree.add({3 * kOneSecond_ns, "map", "odom", Pose(Eigen::Translation3d(0, 2, 0))}, false);
  for (int k = 0; k <= 250; ++k) {
    tree.add({k * kOneSecond_ns / 50, "odom", "base", Pose(Eigen::Translation3d(k * 0.01, 0, 0))}, false);
  }
  tree.sort();
  EXPECT_FALSE(tree.pose_in_root("base", kOneSecond_ns * 9 / 10));
  EXPECT_DOUBLE_EQ((*tree.pose_in_root("base", kOneSecond_ns * 3 / 2))->translation().y(), 1);
  EXPECT_DOUBLE_EQ((*tree.pose_in_root("base", kOneSecond_ns * 7 / 2))->translation().y(), 2);
  EXPECT_FALSE(tree.pose_in_root("base", kOneSecond_ns * 41 / 10));
}

}  // namespace
}  // namespace scanknit::test
