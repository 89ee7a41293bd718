#include <gtest/gtest.h>

#include "measure/solid/oriented_box.h"
#include "measure/solid/thickness.h"
#include "measure/solid/volume.h"
#include "tests/measure/known_shapes.h"

namespace scanknit {
namespace {

Mesh joined(Mesh a, const Mesh& b) {
  const auto first = static_cast<std::uint32_t>(a.positions_m.size());
  a.positions_m.insert(a.positions_m.end(), b.positions_m.begin(), b.positions_m.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({first + i, first + j, first + k});
  return a;
}

Mesh inside_out(Mesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TEST(MeshVolume, IsExactForClosedMeshes) {
  EXPECT_NEAR(*measure_volume(test::box(0.02, 0.03, 0.05)).volume_m3, 3e-5, 1e-11);
  EXPECT_NEAR(*measure_volume(test::moved(test::box(0.02, 0.03, 0.05), test::some_pose())).volume_m3, 3e-5, 1e-10);
  const double ball = 4 * std::numbers::pi / 3 * std::pow(0.05, 3);
  EXPECT_NEAR(*measure_volume(test::ball(0.05)).volume_m3, ball, 0.01 * ball);
}

TEST(MeshVolume, ACavityIsLeftOut) {
  const Mesh shell = joined(test::box(0.04, 0.04, 0.04), inside_out(test::box(0.02, 0.02, 0.02)));
  EXPECT_NEAR(*measure_volume(shell).volume_m3, 0.04 * 0.04 * 0.04 - 0.02 * 0.02 * 0.02, 1e-10);
}

TEST(MeshVolume, AnInsideOutMeshHasItsVolumeAndSaysSo) {
  const MeshVolume measured = measure_volume(inside_out(test::box(0.02, 0.03, 0.05)));
  EXPECT_TRUE(measured.is_inside_out);
  EXPECT_NEAR(*measured.volume_m3, 3e-5, 1e-11);
}

TEST(MeshVolume, AnOpenMeshHasNoneButOneWithItsHolesCovered) {
  Mesh open = test::box(0.02, 0.03, 0.05);
  open.triangles.erase(open.triangles.begin() + 4, open.triangles.begin() + 6);  // a whole face
  const MeshVolume measured = measure_volume(open);
  EXPECT_FALSE(measured.volume_m3.has_value());
  EXPECT_EQ(measured.border_edges, 4u);
  EXPECT_NEAR(*measured.covered_volume_m3, 3e-5, 1e-11);
}

TEST(MeshVolume, BoxesThatTouchAtAnEdgeHaveOne) {
  Mesh two = test::box(2, 2, 2);
  for (const Eigen::Vector3f& p : test::box(2, 2, 2).positions_m)
    two.positions_m.push_back(p + Eigen::Vector3f(2, 2, 0));
  // The second's corners at x = 1, y = 1 are the first's.
  const auto of_second = [](std::uint32_t i) { return i == 0 ? 3u : i == 4 ? 7u : 8 + i; };
  for (const auto& [a, b, c] : test::box(2, 2, 2).triangles) {
    two.triangles.push_back({of_second(a), of_second(b), of_second(c)});
  }
  const MeshVolume measured = measure_volume(two);
  EXPECT_EQ(measured.tangled_edges, 0u);
  EXPECT_NEAR(*measured.volume_m3, 16, 1e-6);
}

TEST(MeshVolume, SheetsWithoutAnInsideHaveNone) {
  Mesh fin = test::box(0.02, 0.03, 0.05);
  fin.positions_m.emplace_back(0.1f, 0.1f, 0.1f);
  fin.triangles.push_back({0, 1, 8});  // a third triangle at an edge of the box
  Mesh turned = test::box(0.02, 0.03, 0.05);
  std::swap(turned.triangles[2][0], turned.triangles[2][1]);
  for (const Mesh& mesh : {fin, turned}) {
    const MeshVolume measured = measure_volume(mesh);
    EXPECT_GT(measured.tangled_edges, 0u);
    EXPECT_FALSE(measured.volume_m3.has_value());
    EXPECT_FALSE(measured.covered_volume_m3.has_value());
  }
}

TEST(OrientedBox, OfATurnedBoxIsThatBox) {
  const OrientedBox found = find_oriented_box(test::moved(test::box(0.02, 0.03, 0.05), test::some_pose()));
  EXPECT_TRUE(found.size_m.isApprox(Eigen::Vector3d(0.05, 0.03, 0.02), 1e-5)) << found.size_m.transpose();
  EXPECT_LT((found.centre_m - test::some_pose().translation()).norm(), 1e-6);
  EXPECT_NEAR(std::abs(found.axes.col(0).dot(test::some_pose().linear().col(2))), 1, 1e-6);
  EXPECT_NEAR(found.axes.determinant(), 1, 1e-9);
}

TEST(OrientedBox, OfAnUprightBoxIsAlongTheAxes) {
  const OrientedBox found = find_oriented_box(test::box(0.02, 0.03, 0.05));
  EXPECT_TRUE(found.size_m.isApprox(Eigen::Vector3d(0.05, 0.03, 0.02), 1e-6)) << found.size_m.transpose();
}

TEST(OrientedBox, OfATurnedCubeIsTheCube) {
  Pose turn = Pose::Identity();
  turn.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 1, 0.3).normalized()).toRotationMatrix();
  EXPECT_NEAR(find_oriented_box(test::moved(test::box(1, 1, 1), turn)).volume_m3(), 1, 1e-5);
}

TEST(OrientedBox, ContainsEveryVertex) {
  const Mesh mesh = test::moved(test::lump(), test::some_pose());
  const OrientedBox found = find_oriented_box(mesh);
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    const Eigen::Vector3d inside = found.axes.transpose() * (p.cast<double>() - found.centre_m);
    EXPECT_TRUE((inside.cwiseAbs() - found.size_m / 2).maxCoeff() < 1e-7);
  }
}

WallThickness thickness_of(const Mesh& mesh, std::optional<double> thin_m = std::nullopt) {
  return measure_thickness(mesh, TriangleBvh(mesh), measure_volume(mesh).is_inside_out, thin_m, 20'000);
}

TEST(WallThickness, OfABallIsItsDiameter) {
  const WallThickness walls = thickness_of(test::ball(0.05));
  EXPECT_NEAR(walls.median_m, 0.1, 0.001);
  EXPECT_NEAR(walls.p01_m, 0.1, 0.001);
  EXPECT_EQ(walls.share_measured, 1);
}

TEST(WallThickness, OfAHollowBoxIsThatOfItsWalls) {
  const Mesh hollow = joined(test::box(0.04, 0.04, 0.04), inside_out(test::box(0.038, 0.038, 0.038)));
  const WallThickness walls = thickness_of(hollow, 0.0012);
  EXPECT_NEAR(walls.median_m, 0.001, 1e-5);
  EXPECT_NEAR(walls.min_m, 0.001, 1e-6);
  // Rays from the outer faces' rims, a millimetre wide, run along a wall; all others are thin.
  const double outer = 6 * 0.04 * 0.04, inner = 6 * 0.038 * 0.038;
  EXPECT_NEAR(*walls.share_thin, 2 * inner / (outer + inner), 0.005);
}

TEST(WallThickness, OfAnInsideOutBoxIsTheSame) {
  const WallThickness walls = thickness_of(inside_out(test::box(0.002, 0.04, 0.04)), 0.003);
  EXPECT_NEAR(walls.min_m, 0.002, 1e-6);
  EXPECT_NEAR(*walls.share_thin, 2 * 0.04 * 0.04 / (2 * 0.04 * 0.04 + 4 * 0.002 * 0.04), 0.005);
}

TEST(WallThickness, AnOpenSheetHasNone) {
  const WallThickness walls = thickness_of(test::sheet(0.1, 10), 0.01);
  EXPECT_EQ(walls.share_measured, 0);
  EXPECT_EQ(walls.share_thin.value_or(0), 0);
}

}  // namespace
}  // namespace scanknit
