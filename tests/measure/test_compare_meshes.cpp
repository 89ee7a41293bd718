#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "measure/compare/compare_meshes.h"
#include "measure/compare/deviation_colours.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

constexpr double kOnePercent = 0.01;
constexpr std::size_t kAreaPoints = 20'000;

void expect_near_share(double value, double expected) {
  EXPECT_NEAR(value, expected, kOnePercent * std::abs(expected));
}

TEST(CompareMeshes, ALargerBallLiesOutsideBySoMuch) {
  const auto [deviation, beyond, mesh, reference] = [] {
    const ComparedMeshes c = compare_meshes(test::ball(0.0502), test::ball(0.05), 0.0001, kAreaPoints);
    return std::tuple(c.deviation, c.beyond, c.mesh, c.reference);
  }();
  expect_near_share(deviation.vertices.mean_m, 0.0002);
  expect_near_share(deviation.area.mean_m, 0.0002);
  expect_near_share(deviation.area.rms_m, 0.0002);
  expect_near_share(deviation.vertices.absolute_percentiles_m[2], 0.0002);
  expect_near_share(deviation.reference_area.mean_m, -0.0002);  // inside of the larger one
  EXPECT_EQ(beyond->vertices, 1);
  EXPECT_EQ(beyond->area, 1);
  EXPECT_EQ(reference.edges.border, 0u);
}

TEST(CompareMeshes, ASmallerBallLiesInside) {
  const ComparedMeshes compared = compare_meshes(test::ball(0.0497), test::ball(0.05), 0.00031, kAreaPoints);
  expect_near_share(compared.deviation.area.mean_m, -0.0003);
  expect_near_share(compared.deviation.vertices.min_m, -0.0003);
  EXPECT_EQ(compared.beyond->area, 0);
}

TEST(CompareMeshes, SignsAreThoseOfASoundReferenceWhenItIsInsideOut) {
  Mesh inside_out = test::ball(0.05);
  for (Triangle& t : inside_out.triangles) std::swap(t[1], t[2]);
  const ComparedMeshes compared = compare_meshes(test::ball(0.0502), inside_out, std::nullopt, kAreaPoints);
  EXPECT_TRUE(compared.reference.is_inside_out);
  expect_near_share(compared.deviation.area.mean_m, 0.0002);
}

TEST(CompareMeshes, OffsetFacesOfABoxHaveTheirShares) {
  // Only the faces across x move: the area of the longer box beyond half a millimetre is that of two faces.
  const ComparedMeshes compared = compare_meshes(test::box(0.042, 0.06, 0.08), test::box(0.04, 0.06, 0.08), 0.0009999);
  EXPECT_NEAR(compared.deviation.vertices.mean_m, 0.001, 1e-8);
  const double ends = 2 * 0.06 * 0.08, all = ends + 2 * 0.042 * (0.06 + 0.08);
  EXPECT_NEAR(compared.beyond->area, ends / all, kOnePercent * ends / all);
  EXPECT_NEAR(compared.deviation.area.max_m, 0.001, 1e-8);
}

TEST(CompareMeshes, ADentHasItsDepthAndItsShareOfTheArea) {
  const ComparedMeshes compared = compare_meshes(test::sheet(0.1, 200, 0.002), test::sheet(0.1, 50), 0.001);
  expect_near_share(compared.deviation.vertices.min_m, -0.002);
  expect_near_share(compared.deviation.area.min_m, -0.002);
  EXPECT_NEAR(compared.deviation.area.max_m, 0, 1e-9);
  // Half the depth is reached at half the radius: a disc of 10 mm.
  const double disc = std::numbers::pi * 0.01 * 0.01, sheet = 0.1 * 0.1;
  EXPECT_NEAR(compared.beyond->area, disc / sheet, 0.02 * disc / sheet);  // the dent's slope has a little more area
  EXPECT_GT(compared.reference.edges.border, 0u);
}

TEST(CompareMeshes, IsTheSameForAnyNumberOfThreads) {
  const auto compare = [] { return compare_meshes(test::lump(), test::ball(0.045), 0.001, 10'000); };
  const ComparedMeshes many = compare();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const ComparedMeshes single = compare();
  EXPECT_EQ(single.deviation.vertices_m, many.deviation.vertices_m);
  EXPECT_EQ(single.deviation.area.rms_m, many.deviation.area.rms_m);
  EXPECT_EQ(single.deviation.histogram.shares, many.deviation.histogram.shares);
}

TEST(DeviationStats, PercentilesAreOfTheRank) {
  std::vector<double> distances_m;
  for (int i = 100; i >= 1; --i) distances_m.push_back(i % 2 == 0 ? i : -i);
  const DeviationStats stats = deviation_stats(distances_m);
  EXPECT_EQ(stats.count, 100u);
  EXPECT_EQ(stats.mean_m, 0.5);
  EXPECT_EQ(stats.mean_absolute_m, 50.5);
  EXPECT_EQ(stats.absolute_percentiles_m[0], 50);
  EXPECT_EQ(stats.absolute_percentiles_m[3], 99);
  EXPECT_EQ(stats.percentiles_m[0], -99);
  EXPECT_EQ(stats.min_m, -99);
  EXPECT_EQ(stats.max_m, 100);
  EXPECT_EQ(share_beyond(distances_m, 90), 0.1);
}

TEST(DeviationStats, OfNothingAreZero) {
  EXPECT_EQ(deviation_stats({}).rms_m, 0);
  EXPECT_EQ(share_beyond({}, 1), 0);
  EXPECT_GT(scale_end_m({}), 0);
}

TEST(DeviationHistogram, CountsEveryDistanceOnce) {
  const std::vector<double> distances_m = {-3, -2, -1, 0, 0, 1, 2, 2.5};
  const DeviationHistogram histogram = deviation_histogram(distances_m, 2);
  EXPECT_EQ(histogram.shares.size(), kHistogramBins);
  EXPECT_EQ(histogram.share_below, 0.125);
  EXPECT_EQ(histogram.share_above, 0.125);
  EXPECT_EQ(histogram.shares.front(), 0.125);
  EXPECT_EQ(histogram.shares.back(), 0.125);
  EXPECT_EQ(histogram.shares[kHistogramBins / 2], 0.25);
}

TEST(DeviationColours, AreBlueBelowGreyAmidAndRedAbove) {
  const Rgb8 below = deviation_colour(-5, 1), none = deviation_colour(0, 1), above = deviation_colour(1, 1);
  EXPECT_EQ(below, deviation_colour(-1, 1));
  EXPECT_GT(below.b, below.r);
  EXPECT_GT(above.r, above.b);
  EXPECT_NEAR(none.r, none.b, 10);
}

}  // namespace
}  // namespace scanknit
