// Normals against planes whose normal is known.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <vector>

#include "acquire/filter/depth_filter.h"
#include "test_filter_scenes.h"

namespace scanknit::test {
namespace {

constexpr double kExact = 0.05 * kDegree;  // float depth of one plane over a few pixels

struct Errors {
  double known = 0;  // share of the valid pixels that have a normal
  double median = 0;
  double p95 = 0;
};

Errors errors_of(const DepthImage& depth_m, const CameraIntrinsics& camera, const Eigen::Vector3d& truth) {
  const auto normals = estimate_normals(depth_m, camera, {});
  std::vector<double> angles;
  for (const Eigen::Vector3f& n : normals.pixels()) {
    if (n.squaredNorm() > 0) angles.push_back(std::acos(std::clamp(n.cast<double>().dot(truth), -1.0, 1.0)));
  }
  if (angles.empty()) return {};
  std::sort(angles.begin(), angles.end());
  const auto count = static_cast<double>(angles.size());
  return {count / valid_pixels(depth_m), angles[angles.size() / 2], angles[angles.size() * 95 / 100]};
}

TEST(Normals, OfAPlaneAreExactAtAnyTilt) {
  for (const double degrees : {0.0, 30.0, 50.0, 65.0}) {
    const Eigen::Vector3d n = tilted(degrees * kDegree);
    const Errors errors = errors_of(render_plane(n, kCamera), kCamera, n);
    EXPECT_LT(errors.p95, kExact) << degrees;
    EXPECT_EQ(errors.known, 1.0) << degrees;
  }
}

TEST(Normals, OfAPlaneAreExactWithNegativeFy) {
  const CameraIntrinsics camera{160, 120, 481.2, -480, 79.5, 59.5};
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.5, -0.8).normalized();
  EXPECT_LT(errors_of(render_plane(n, camera), camera, n).p95, kExact);
}

TEST(Normals, OfAPlaneAreExactWithDifferentFocalLengths) {
  const CameraIntrinsics camera{160, 120, 500, 620, 70, 66};
  const Eigen::Vector3d n = Eigen::Vector3d(0.4, -0.3, -0.8).normalized();
  EXPECT_LT(errors_of(render_plane(n, camera), camera, n).p95, kExact);
}

TEST(Normals, SurviveALatticeOfHoles) {
  const Eigen::Vector3d n = tilted(40 * kDegree);
  const Errors errors = errors_of(with_lattice(render_plane(n, kCamera)), kCamera, n);
  EXPECT_LT(errors.p95, kExact);
  EXPECT_GT(errors.known, 0.98);  // the corners of the picture may have too few neighbours
}

TEST(Normals, AreStableUnderKinectNoise) {
  const Eigen::Vector3d n = tilted(30 * kDegree);
  const Errors errors = errors_of(with_noise(render_plane(n, kCamera), {}), kCamera, n);
  // The estimator aims at 0.06 rad (3.4 degrees) for each of two slopes; the median of such an angle is 1.18 times
  // that.
  EXPECT_LT(errors.median, 4 * kDegree);
  EXPECT_LT(errors.p95, 9 * kDegree);
}

TEST(Normals, AreStableUnderNoiseBehindALattice) {
  const Eigen::Vector3d n = tilted(30 * kDegree);
  const Errors errors = errors_of(with_lattice(with_noise(render_plane(n, kCamera), {})), kCamera, n);
  EXPECT_LT(errors.median, 6 * kDegree);
}

TEST(Normals, DoNotReachAcrossAStep) {
  DepthImage depth_m(60, 40, 0.6F);
  for (int y = 0; y < 40; ++y) {
    for (int x = 30; x < 60; ++x) depth_m.at(x, y) = 0.8F;
  }
  const CameraIntrinsics camera{60, 40, 600, 600, 29.5, 19.5};
  const auto normals = estimate_normals(depth_m, camera, {});
  for (int x = 20; x < 40; ++x) EXPECT_NEAR(normals.at(x, 20).z(), -1.0F, 1e-4F) << x;
}

TEST(Normals, AreUnknownWithoutEnoughNeighbours) {
  DepthImage depth_m(20, 20);
  depth_m.at(10, 10) = 1.0F;
  const auto normals = estimate_normals(depth_m, {20, 20, 100, 100, 9.5, 9.5}, {});
  EXPECT_TRUE(normals.at(10, 10).isZero());
}

TEST(Normals, AreUnknownOnALineOfPixels) {
  DepthImage depth_m(20, 20);
  for (int x = 0; x < 20; ++x) depth_m.at(x, 10) = 1.0F;
  EXPECT_TRUE(estimate_normals(depth_m, {20, 20, 100, 100, 9.5, 9.5}, {}).at(10, 10).isZero());
}

TEST(Normals, DoNotDependOnTheNumberOfThreads) {
  const DepthImage depth_m = with_lattice(with_noise(render_plane(tilted(50 * kDegree), kCamera), {}));
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return estimate_normals(depth_m, kCamera, {});
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(8));
}

}  // namespace
}  // namespace scanknit::test
