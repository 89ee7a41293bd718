// Surfaces whose truth is known: spheres, tori, planes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

/// Signed distance, negative inside.
Dense sphere(int n, double radius) {
  const double c = (n - 1) / 2.0 + 0.1;  // off the grid's symmetry
  return test::dense_from(n, [=](double x, double y, double z) {
    return std::sqrt((x - c) * (x - c) + (y - c) * (y - c) + (z - c) * (z - c)) - radius;
  });
}

Dense torus(int n, double major, double minor) {
  const double c = (n - 1) / 2.0 + 0.1;
  return test::dense_from(
      n, [=](double x, double y, double z) { return std::hypot(std::hypot(x - c, y - c) - major, z - c) - minor; });
}

/// A chord of the sphere of radius R lies up to h^2 / (8 R) inside; the volume's relative error is about its triple.
constexpr double kVolumeTolerance = 0.01;

TEST(Surface, SphereIsClosedAndOfEulerCharacteristicTwo) {
  const MeshCheck check = check_mesh(test::extract(sphere(40, 15)).mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.euler, 2);
}

TEST(Surface, SphereHasItsVolumeAndFacesOutwards) {
  const double volume = signed_volume_m3(test::extract(sphere(40, 15)).mesh);
  const double truth = 4.0 / 3.0 * std::numbers::pi * 15 * 15 * 15;
  EXPECT_NEAR(volume / truth, 1, kVolumeTolerance);
}

TEST(Surface, TorusHasEulerCharacteristicZero) {
  const MeshCheck check = check_mesh(test::extract(torus(40, 11, 4)).mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.euler, 0);
}

TEST(Surface, IsovalueMovesTheSurface) {
  ExtractConfig config;
  config.isovalue = 2;  // the sphere of radius 12 + 2
  const double volume = signed_volume_m3(test::extract(sphere(40, 12), config).mesh);
  EXPECT_NEAR(volume / (4.0 / 3.0 * std::numbers::pi * 14 * 14 * 14), 1, kVolumeTolerance);
}

TEST(Surface, HighInsideTurnsTrianglesAndNormals) {
  ExtractConfig config;
  config.inside = InsideSide::kHigh;
  const Dense volume = sphere(24, 8);
  const Mesh low = test::extract(volume).mesh;
  const Mesh high = test::extract(volume, config).mesh;
  EXPECT_FLOAT_EQ(static_cast<float>(signed_volume_m3(high)), -static_cast<float>(signed_volume_m3(low)));
  EXPECT_EQ(high.normals.front(), -low.normals.front());
}

TEST(Surface, AutomaticInsideIsHighForVolumesThatAreNoDistances) {
  const auto grid = test::make_grid(sphere(24, 8));
  FieldView view = test::view_of(*grid);
  view.is_signed_distance = false;
  EXPECT_LT(signed_volume_m3(extract_surface(view, {}).value().mesh), 0);
}

TEST(Surface, LiesInTheWorldFrame) {
  const Mesh mesh = test::extract(sphere(24, 8), {}, {{-30, 16, 5}, 0.25, {1, 2, 3}}).mesh;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : mesh.positions_m) mean += p.cast<double>();
  mean /= static_cast<double>(mesh.positions_m.size());
  const Eigen::Vector3d centre =
      0.25 * (Eigen::Vector3d(-30, 16, 5) + Eigen::Vector3d::Constant(11.6)) + Eigen::Vector3d(1, 2, 3);
  constexpr double kTenthVoxel = 0.025;  // the vertices are not quite evenly spread
  EXPECT_LT((mean - centre).norm(), kTenthVoxel);
}

TEST(Surface, DoesNotDependOnWhereTheBlocksBegin) {
  const Dense volume = test::white_noise(20, 4);
  const MeshCheck expected = check_mesh(test::extract(volume).mesh);
  for (int shift = 1; shift < 8; ++shift) {
    const MeshCheck check = check_mesh(test::extract(volume, {}, {{-shift, shift - 12, -3 * shift}, 1, {}}).mesh);
    EXPECT_EQ(check.vertices, expected.vertices);
    EXPECT_EQ(check.triangles, expected.triangles);
    EXPECT_EQ(check.euler, expected.euler);
    EXPECT_EQ(check.boundary_edges, expected.boundary_edges);
  }
}

TEST(Surface, CountsItsCells) {
  // 3 x 3 x 3 samples with one Low in the middle: eight cells of configuration 1.
  Dense volume(3, 1);
  volume.at(1, 1, 1) = -1;
  const CaseCounts cases = test::extract(volume).cases;
  EXPECT_EQ(cases.of_configuration(1), 8u);
  EXPECT_EQ(cases.of_configuration(0), 0u);
  EXPECT_EQ(cases.skipped_cells, 0u);
}

TEST(Surface, CountsTheCellsThatAnUnobservedSampleTookFromIt) {
  Dense volume(5, 1);
  for (int y = 0; y < 5; ++y) {
    for (int z = 0; z < 5; ++z) volume.at(0, y, z) = volume.at(1, y, z) = -1;
  }
  volume.at(2, 2, 2) = test::kNaN;
  EXPECT_EQ(test::extract(volume).cases.skipped_cells, 4u + 9u);  // 9 begin at the upper borders of y and z
}

TEST(Surface, CountsAmbiguousFaces) {
  Dense volume(2, -1);
  volume.at(0, 0, 0) = volume.at(1, 1, 0) = 2;
  const CaseCounts cases = test::extract(volume).cases;
  EXPECT_EQ(cases.of_configuration(3), 1u);
  EXPECT_EQ(cases.ambiguous_faces_joined, 1u);
  EXPECT_EQ(cases.ambiguous_faces_separated, 0u);
}

TEST(Surface, SmallComponentsGoWhenAsked) {
  Dense volume = sphere(24, 8);
  volume.at(1, 1, 1) = -1;  // eight triangles
  ExtractConfig config;
  config.min_component_triangles = 9;
  const Surface surface = test::extract(volume, config);
  EXPECT_EQ(surface.cases.components_removed, 1u);
  EXPECT_EQ(check_mesh(surface.mesh).components, 1u);
  EXPECT_EQ(check_mesh(test::extract(volume).mesh).components, 2u);
}

TEST(Surface, NeighbouringCellsAgreeOnAFaceTie) {
  // The shared face is 1 -1 / -1 1, whose saddle ties; the cells differ elsewhere, and are mirrored.
  for (const float left : {-3.0f, 3.0f}) {
    for (const float right : {-5.0f, 5.0f}) {
      Dense volume(3, test::kNaN);
      for (int y = 0; y < 2; ++y) {
        for (int z = 0; z < 2; ++z) {
          volume.at(0, y, z) = left;
          volume.at(1, y, z) = y == z ? 1.0f : -1.0f;
          volume.at(2, y, z) = right;
        }
      }
      const MeshCheck check = check_mesh(test::extract(volume).mesh);
      EXPECT_TRUE(check.is_manifold());
      EXPECT_EQ(check.boundary_edges, test::expected_boundary_edges(volume, 0));
    }
  }
}

}  // namespace
}  // namespace scanknit
