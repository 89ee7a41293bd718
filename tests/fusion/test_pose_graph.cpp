#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fusion/loops/pose_graph.h"

namespace scanknit::pose_graph_test {
namespace {

Pose motion(const Eigen::Vector3d& translation, const Eigen::Vector3d& rotation) {
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  if (rotation.norm() > 0) pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  return pose;
}

Pose small_motion(std::mt19937& random, double metres, double radians) {
  std::uniform_real_distribution<double> one(-1, 1);
  const Eigen::Vector3d t(one(random), one(random), one(random));
  const Eigen::Vector3d r(one(random), one(random), one(random));
  return motion(metres * t, radians * r);
}

Matrix6d information(double metres, double radians) {
  Matrix6d matrix = Matrix6d::Zero();
  matrix.topLeftCorner<3, 3>().diagonal().setConstant(1 / (metres * metres));
  matrix.bottomRightCorner<3, 3>().diagonal().setConstant(1 / (radians * radians));
  return matrix;
}

/// A walk round a circle of 2 m.
std::vector<Pose> circle(std::size_t nodes) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < nodes; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(nodes);
    poses.push_back(motion({2 * std::cos(angle), 2 * std::sin(angle), 0.1 * angle}, {0.2, 0.1, angle}));
  }
  return poses;
}

double farthest(const std::vector<Pose>& found, const std::vector<Pose>& truth) {
  double most = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    most = std::max(most, (found[i].translation() - truth[i].translation()).norm());
  }
  return most;
}

struct Walk {
  std::vector<Pose> truth = circle(60);
  std::vector<Pose> poses;  ///< as steps with a bias lead to
  std::vector<PoseEdge> edges;

  Walk() {
    const Pose bias = motion({0.004, -0.002, 0.003}, {0.003, -0.002, 0.004});
    poses.push_back(truth[0]);
    for (std::size_t i = 1; i < truth.size(); ++i) {
      const Pose step = truth[i - 1].inverse() * truth[i] * bias;
      poses.push_back(poses.back() * step);
      edges.push_back({i - 1, i, step, information(0.005, 0.005)});
    }
  }
  void add_loop(std::size_t from, std::size_t to, const Pose& error = Pose::Identity()) {
    edges.push_back({from, to, truth[from].inverse() * truth[to] * error, information(0.003, 0.003), true});
  }
};

TEST(PoseGraph, LeavesPosesThatAgreeWhereTheyAre) {
  Walk walk;
  const std::vector<Pose> before = walk.poses;
  const auto result = optimise_poses(walk.poses, walk.edges);
  EXPECT_TRUE(result.has_converged);
  EXPECT_LT(farthest(walk.poses, before), 1e-9);
}

TEST(PoseGraph, ALoopDistributesTheDrift) {
  Walk walk;
  const double drift = farthest(walk.poses, walk.truth);
  ASSERT_GT(drift, 0.2);
  walk.add_loop(59, 0);
  walk.add_loop(58, 1);
  const auto result = optimise_poses(walk.poses, walk.edges);
  EXPECT_TRUE(result.has_converged);
  EXPECT_LT(farthest(walk.poses, walk.truth), 0.3 * drift);
  EXPECT_LT((walk.poses[59].inverse() * walk.poses[0]).translation().norm() -
                (walk.truth[59].inverse() * walk.truth[0]).translation().norm(),
            0.005);
  EXPECT_GT(result.weights.back(), 0.5);
}

TEST(PoseGraph, RecoversExactlyWhatExactEdgesSay) {
  Walk walk;
  std::mt19937 random(5);
  walk.edges.clear();
  for (std::size_t i = 1; i < walk.truth.size(); ++i) {
    walk.edges.push_back({i - 1, i, walk.truth[i - 1].inverse() * walk.truth[i], information(0.01, 0.01)});
    walk.poses[i] = walk.truth[i] * small_motion(random, 0.3, 0.5);
  }
  const auto result = optimise_poses(walk.poses, walk.edges);
  EXPECT_TRUE(result.has_converged);
  EXPECT_LT(farthest(walk.poses, walk.truth), 1e-6);
}

TEST(PoseGraph, WrongLoopsLoseTheirWeight) {
  Walk right, wrong;
  for (Walk* walk : {&right, &wrong}) {
    for (const std::size_t i : {0U, 1U, 2U, 3U}) walk->add_loop(59 - i, i);
  }
  EXPECT_TRUE(optimise_poses(right.poses, right.edges).has_converged);
  wrong.add_loop(10, 40, motion({1.5, 0.3, 0}, {0, 0, 0.4}));
  wrong.add_loop(20, 50, motion({-0.5, 0.9, 0.2}, {0.3, 0, 0}));
  const auto result = optimise_poses(wrong.poses, wrong.edges);
  EXPECT_LT(farthest(wrong.poses, right.poses), 0.005);
  const std::size_t edges = result.weights.size();
  EXPECT_LT(result.weights[edges - 1], 0.01);
  EXPECT_LT(result.weights[edges - 2], 0.01);
  EXPECT_GT(result.sigmas[edges - 1], 20);
}

TEST(PoseGraph, AnEdgeThatHoldsSomeDirectionsLeavesTheOthers) {
  std::vector<Pose> poses{Pose::Identity(), motion({1, 0, 0}, {0, 0, 0})};
  Matrix6d plane = information(0.01, 0.01);
  plane(1, 1) = 0;  // slides along y
  std::vector<PoseEdge> edges{{0, 1, motion({2, 5, 0}, {0, 0, 0}), plane}};
  EXPECT_TRUE(optimise_poses(poses, edges).has_converged);
  EXPECT_NEAR(poses[1].translation().x(), 2, 1e-6);
  EXPECT_NEAR(poses[1].translation().y(), 0, 1e-6);
}

TEST(PoseGraph, NodesWithoutEdgesStay) {
  std::vector<Pose> poses = circle(5);
  const std::vector<Pose> before = poses;
  EXPECT_TRUE(optimise_poses(poses, {}).has_converged);
  EXPECT_EQ(farthest(poses, before), 0);
}

}  // namespace
}  // namespace scanknit::pose_graph_test
