#include <gtest/gtest.h>

#include <vector>

#include "measure/compare/compare_meshes.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

TEST(DeviationRegions, DivideTheBoxAndLeaveOutWhatIsEmpty) {
  const std::vector<Eigen::Vector3d> points = {{0.1, 0.1, 0.1}, {2.9, 0.1, 0.1}, {9, -5, 0.5}, {1.5, 1.5, 2.5}};
  const std::vector<double> distances = {0.001, 0.002, -0.004, 0};
  const Eigen::AlignedBox3d box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(3));
  const auto regions = deviation_regions(points, distances, box, 0.003);
  ASSERT_EQ(regions.size(), 3u);
  EXPECT_EQ(regions[0].area.count, 1u);
  EXPECT_TRUE(regions[1].box_m.isApprox(Eigen::AlignedBox3d(Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(3, 1, 1))));
  EXPECT_EQ(regions[1].area.count, 2u) << "a point beyond the box counts in the nearest part";
  EXPECT_NEAR(regions[1].area.mean_m, -0.001, 1e-12);
  EXPECT_NEAR(regions[1].area_share, 0.5, 1e-12);
  EXPECT_NEAR(regions[1].beyond.value(), 0.5, 1e-12);
  EXPECT_TRUE(regions[2].box_m.isApprox(Eigen::AlignedBox3d(Eigen::Vector3d(1, 1, 2), Eigen::Vector3d(2, 2, 3))));
}

TEST(DeviationRegions, ADentIsInItsPartOnly) {
  const Mesh whole = test::ball(0.05);
  Mesh dented = whole;
  const Eigen::Vector3f place(0.05f, 0, 0);
  for (Eigen::Vector3f& p : dented.positions_m) {
    if ((p - place).norm() < 0.012f) p *= 0.96f;  // 2 mm inwards
  }
  const ComparedMeshes compared = compare_meshes(dented, whole);
  ASSERT_GT(compared.deviation.regions.size(), 10u);
  double share = 0;
  for (const DeviationRegion& region : compared.deviation.regions) {
    share += region.area_share;
    EXPECT_FALSE(region.beyond) << "no tolerance was given";
    if (region.box_m.exteriorDistance(place.cast<double>()) < 1e-6) {
      EXPECT_LT(region.area.min_m, -0.0015);
    } else {
      EXPECT_LT(region.area.max_absolute_m, 1e-6);
    }
  }
  EXPECT_NEAR(share, 1, 1e-12);
}

}  // namespace
}  // namespace scanknit
