#include <gtest/gtest.h>

#include "core/counter_random.h"
#include "measure/fit/circle_fit.h"
#include "measure/fit/plane_fit.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

TEST(PlaneFit, OfABoxFaceIsTheFace) {
  const auto plane = fit_plane(test::box(0.02, 0.03, 0.05), {0.002, 0.001, 0.025}, 0.008);
  ASSERT_TRUE(plane) << plane.error().text();
  EXPECT_TRUE(plane->normal.isApprox(Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_NEAR(plane->offset_m, 0.025, 1e-8);
  EXPECT_LT(plane->max_m - plane->min_m, 1e-8);
  EXPECT_NEAR(plane->share, 1, 1e-9);
}

TEST(PlaneFit, LeavesOutTheOtherFacesOfAnEdge) {
  const auto plane = fit_plane(test::box(0.02, 0.03, 0.05), {0.0095, 0, 0.025}, 0.006);
  ASSERT_TRUE(plane) << plane.error().text();
  EXPECT_TRUE(plane->normal.isApprox(Eigen::Vector3d::UnitZ(), 1e-6));
  EXPECT_LT(plane->share, 0.7);
}

TEST(PlaneFit, OfANoisySheetIsTheSheet) {
  Mesh noisy = test::sheet(0.1, 100);
  for (std::size_t i = 0; i < noisy.positions_m.size(); ++i) {
    CounterRandom random(7, 0, i);
    noisy.positions_m[i].z() += static_cast<float>(1e-4 * random.gaussian());
  }
  const auto plane = fit_plane(test::moved(noisy, test::some_pose()), test::some_pose().translation(), 0.04);
  ASSERT_TRUE(plane) << plane.error().text();
  EXPECT_LT(std::acos(plane->normal.dot(test::some_pose().linear().col(2))), 0.001);
  EXPECT_NEAR(plane->normal.dot(test::some_pose().translation()), plane->offset_m, 1e-5);
  EXPECT_LT(plane->rms_m, 1e-4);
  EXPECT_GT(plane->rms_m, 2e-5);
}

TEST(PlaneFit, AwayFromTheSurfaceIsAnError) {
  const auto plane = fit_plane(test::box(0.02, 0.03, 0.05), {0, 0, 0.1}, 0.01);
  ASSERT_FALSE(plane);
  EXPECT_EQ(plane.error().code, ErrorCode::kTooLittle);
}

TEST(CircleFit, OfAHoleInAPlateIsTheHole) {
  const Mesh plate = test::moved(test::plate_with_hole(0.06, 0.01, 0.008), test::some_pose());
  const auto circle = fit_circle(plate, test::some_pose() * Eigen::Vector3d(0.001, 0, 0), 0.014);
  ASSERT_TRUE(circle) << circle.error().text();
  EXPECT_NEAR(circle->radius_m, 0.008, 0.01 * 0.008);
  EXPECT_TRUE(circle->is_hole);
  EXPECT_LT((circle->centre_m - test::some_pose().translation()).norm(), 5e-5);
  EXPECT_NEAR(std::abs(circle->axis.dot(test::some_pose().linear().col(2))), 1, 1e-6);
  EXPECT_GT(circle->arc_rad, 6.2);
}

TEST(CircleFit, OfHalfARodIsTheRod) {
  Mesh rod;  // half a round wall, open
  constexpr std::uint32_t kSteps = 48;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    const double angle = std::numbers::pi * i / kSteps;
    for (const double z : {0.0, 0.02, 0.04}) {
      rod.positions_m.push_back(Eigen::Vector3d(0.012 * std::cos(angle), 0.012 * std::sin(angle), z).cast<float>());
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    for (std::uint32_t k = 0; k < 2; ++k) {
      const std::uint32_t a = 3 * i + k, b = a + 3;
      rod.triangles.push_back({a, b, b + 1});
      rod.triangles.push_back({a, b + 1, a + 1});
    }
  }
  const auto circle = fit_circle(rod, {0, 0.012, 0.02}, 0.02);
  ASSERT_TRUE(circle) << circle.error().text();
  EXPECT_NEAR(circle->radius_m, 0.012, 0.01 * 0.012);
  EXPECT_FALSE(circle->is_hole);
  EXPECT_NEAR(circle->arc_rad, std::numbers::pi, 0.2);
}

TEST(CircleFit, OfANoisyHoleIsWithinAPercent) {
  Mesh plate = test::plate_with_hole(0.06, 0.01, 0.008);
  for (std::size_t i = 0; i < plate.positions_m.size(); ++i) {
    CounterRandom random(3, 0, i);
    for (float& x : plate.positions_m[i]) x += static_cast<float>(3e-5 * random.gaussian());
  }
  const auto circle = fit_circle(plate, {0, 0, 0}, 0.014);
  ASSERT_TRUE(circle) << circle.error().text();
  EXPECT_NEAR(circle->radius_m, 0.008, 0.01 * 0.008);
}

TEST(CircleFit, AFlatSurfaceHasNone) {
  EXPECT_FALSE(fit_circle(test::sheet(0.1, 20), {0, 0, 0}, 0.02));
  EXPECT_FALSE(fit_circle(test::box(0.02, 0.03, 0.05), {0, 0, 0.1}, 0.01));
}

}  // namespace
}  // namespace scanknit
