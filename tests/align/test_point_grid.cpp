#include <gtest/gtest.h>

#include <random>

#include "fusion/align/point_grid.h"
#include "fusion/align/scan_model.h"

namespace scanknit {
namespace {

std::vector<Eigen::Vector3f> random_points(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> side(-1, 1);
  std::vector<Eigen::Vector3f> points(count);
  for (Eigen::Vector3f& p : points) p = {side(random), side(random), side(random)};
  return points;
}

TEST(PointGrid, FindsTheNearestWithinTheRadius) {
  const auto points = random_points(2000, 1);
  const PointGrid grid(points, 0.12f);
  std::size_t found = 0;
  for (Eigen::Vector3f p : random_points(500, 2)) {
    p *= 1.2f;  // some outside of the box
    std::optional<std::uint32_t> truth;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const float least = truth ? (points[*truth] - p).squaredNorm() : 0.12f * 0.12f;
      if ((points[i] - p).squaredNorm() < least) truth = i;
    }
    EXPECT_EQ(grid.nearest(p), truth);
    found += truth ? 1 : 0;
  }
  EXPECT_GT(found, 100u);
  EXPECT_LT(found, 500u);
}

TEST(PointGrid, OfNoPointsNoneIsNearest) {
  const PointGrid grid({}, 1);
  EXPECT_FALSE(grid.nearest({0, 0, 0}));
}

TEST(ThinOut, KeepsBothSidesOfAThinSheet) {
  OrientedPoints sheet;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3f p(static_cast<float>(i % 10) * 0.001f, static_cast<float>(i / 10) * 0.001f, 0.0001f);
    for (const float side : {-1.0f, 1.0f}) {
      sheet.points_m.push_back(p);
      sheet.normals.push_back({0, 0, side});
      sheet.is_rim.push_back(0);
    }
  }
  const OrientedPoints thin = thin_out(sheet, 0.005);
  EXPECT_EQ(thin.size(), 8u);  // 2 x 2 cubes, two sides
  for (const Eigen::Vector3f& normal : thin.normals) EXPECT_FLOAT_EQ(std::abs(normal.z()), 1);
}

}  // namespace
}  // namespace scanknit
