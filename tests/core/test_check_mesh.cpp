#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "core/mesh.h"
#include "core/mesh/mesh_area.h"
#include "tests/core/sample_meshes.h"

namespace scanknit {
namespace {

/// `count` triangles that share the edge 0-1.
Mesh book(std::uint32_t count) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < count; ++i) {
    const float angle = static_cast<float>(i);
    mesh.positions_m.emplace_back(std::cos(angle), std::sin(angle), 0.5f);
    mesh.triangles.push_back({i % 2, 1 - i % 2, 2 + i});
  }
  return mesh;
}

Mesh joined(Mesh a, const Mesh& b) {
  const auto base = static_cast<std::uint32_t>(a.positions_m.size());
  for (const Eigen::Vector3f& p : b.positions_m) a.positions_m.push_back(p + Eigen::Vector3f(5, 0, 0));
  for (const Triangle& t : b.triangles) a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return a;
}

TEST(CheckMesh, TetrahedronIsAClosedManifoldSphere) {
  const MeshCheck check = check_mesh(test::tetrahedron());
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.euler, 2);
  EXPECT_EQ(check.components, 1u);
}

TEST(CheckMesh, CubeHasTheBoundsOfItsCorners) {
  const MeshCheck check = check_mesh(test::cube());
  EXPECT_EQ(check.min_m, Eigen::Vector3f(-1, -1, -1));
  EXPECT_EQ(check.max_m, Eigen::Vector3f(1, 1, 1));
  EXPECT_EQ(check.euler, 2);
}

TEST(CheckMesh, TorusHasEulerCharacteristicZero) {
  const MeshCheck check = check_mesh(test::torus());
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.euler, 0);
}

TEST(CheckMesh, OneTriangleHasThreeBoundaryEdges) {
  const MeshCheck check = check_mesh(book(1));
  EXPECT_EQ(check.boundary_edges, 3u);
  EXPECT_FALSE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.euler, 1);
}

TEST(CheckMesh, ThreeTrianglesAtAnEdgeAreNotManifold) {
  const MeshCheck check = check_mesh(book(3));
  EXPECT_EQ(check.non_manifold_edges, 1u);
  EXPECT_EQ(check.boundary_edges, 6u);
  EXPECT_FALSE(check.is_manifold());
}

TEST(CheckMesh, BowTieIsANonManifoldVertex) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.non_manifold_vertices, 1u);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(check.components, 1u);
}

TEST(CheckMesh, TwoClosedFansAtAVertexAreNotManifold) {
  Mesh mesh = joined(test::tetrahedron(), test::tetrahedron());
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = v == 4 ? 0 : v;  // both tetrahedra stand on vertex 0
  }
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.non_manifold_vertices, 1u);
  EXPECT_EQ(check.unreferenced_vertices, 1u);
  EXPECT_TRUE(check.is_closed());
}

TEST(CheckMesh, HubOfVeryManyTrianglesIsOneFanFoundInTime) {
  constexpr std::uint32_t kTriangles = 200'000;  // comparing them pair by pair would take minutes
  Mesh mesh;
  mesh.positions_m.assign(kTriangles + 2, Eigen::Vector3f::Zero());
  for (std::uint32_t i = 0; i < kTriangles; ++i) mesh.triangles.push_back({0, i + 1, i + 2});
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.non_manifold_vertices, 0u);
  EXPECT_EQ(check.boundary_edges, kTriangles + 2u);
}

TEST(CheckMesh, FlippedTriangleIsMisorientedAlongItsEdges) {
  Mesh mesh = test::tetrahedron();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.misoriented_edges, 3u);
  EXPECT_FALSE(check.is_manifold());
}

TEST(CheckMesh, CountsDuplicateTriangles) {
  Mesh mesh = test::tetrahedron();
  const Triangle t = mesh.triangles[1];
  mesh.triangles.push_back({t[1], t[2], t[0]});
  EXPECT_EQ(check_mesh(mesh).duplicate_triangles, 1u);
}

TEST(CheckMesh, CountsDegenerateTriangles) {
  Mesh mesh = test::tetrahedron();
  mesh.triangles.push_back({0, 1, 1});
  mesh.positions_m.emplace_back(1, 0, 0);  // where vertex 1 is
  mesh.triangles.push_back({0, 1, 4});
  mesh.positions_m.emplace_back(0.25f, 0, 0);  // between vertices 0 and 1
  mesh.triangles.push_back({0, 1, 5});
  EXPECT_EQ(check_mesh(mesh).degenerate_triangles, 3u);
}

TEST(CheckMesh, CountsComponentsAndLeavesOutUnusedVertices) {
  Mesh mesh = joined(test::tetrahedron(), test::cube());
  mesh.positions_m.emplace_back(9, 9, 9);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_EQ(check.components, 2u);
  EXPECT_EQ(check.unreferenced_vertices, 1u);
  EXPECT_EQ(check.euler, 4);
}

TEST(CheckMesh, EmptyMeshIsWellFormedAndNotClosed) {
  const MeshCheck check = check_mesh(Mesh{});
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_FALSE(check.is_closed());
  EXPECT_EQ(check.components, 0u);
}

TEST(CheckMesh, IndexOutOfRangeIsNotWellFormed) {
  Mesh mesh = test::tetrahedron();
  mesh.triangles[2][1] = 4;
  EXPECT_FALSE(check_mesh(mesh).is_well_formed);
}

TEST(CheckMesh, NaNIsNotWellFormed) {
  Mesh mesh = test::tetrahedron();
  mesh.positions_m[2].y() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(check_mesh(mesh).is_well_formed);
}

TEST(CheckMesh, AttributesOfAnotherLengthAreNotWellFormed) {
  Mesh mesh = test::tetrahedron();
  mesh.colours.resize(3);
  EXPECT_FALSE(check_mesh(mesh).is_well_formed);
  mesh.colours.clear();
  mesh.normals.resize(5, Eigen::Vector3f::UnitX());
  EXPECT_FALSE(check_mesh(mesh).is_well_formed);
}

TEST(MeshArea, LooksOutOfEachTriangleAndAddsUp) {
  const Mesh mesh = test::cube();
  EXPECT_EQ(area_vector_m2(mesh, mesh.triangles[0]), Eigen::Vector3d(-2, 0, 0));
  EXPECT_DOUBLE_EQ(area_m2(mesh), 6 * 4.0);
}

TEST(SignedVolume, IsPositiveOutwardsAndNegativeInwards) {
  Mesh mesh = test::cube();
  EXPECT_DOUBLE_EQ(signed_volume_m3(mesh), 8.0);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_DOUBLE_EQ(signed_volume_m3(mesh), -8.0);
}

TEST(SignedVolume, OfASphereIsNearlyItsFormula) {
  constexpr double kFacetLoss = 0.005;  // a polyhedron of 48 rings lies inside its sphere
  EXPECT_NEAR(signed_volume_m3(test::sphere()), 4 * std::numbers::pi / 3, kFacetLoss * 4);
}

TEST(RemoveSmallComponents, KeepsTheLargeOneAndItsAttributes) {
  Mesh mesh = joined(test::tetrahedron(), test::cube());
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i)
    mesh.colours.push_back({static_cast<std::uint8_t>(i), 0, 0});
  EXPECT_EQ(remove_small_components(mesh, 5), 1u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.positions_m.size(), 8u);
  EXPECT_EQ(mesh.colours.front().r, 4);
  EXPECT_TRUE(check_mesh(mesh).is_closed());
}

TEST(RemoveSmallComponents, KeepsEverythingThatIsLargeEnough) {
  Mesh mesh = joined(test::tetrahedron(), test::cube());
  EXPECT_EQ(remove_small_components(mesh, 4), 0u);
  EXPECT_EQ(mesh.triangles.size(), 16u);
}

TEST(RemoveSmallComponents, CanRemoveAll) {
  Mesh mesh = test::tetrahedron();
  EXPECT_EQ(remove_small_components(mesh, 100), 1u);
  EXPECT_TRUE(mesh.empty());
  EXPECT_TRUE(mesh.positions_m.empty());
}

}  // namespace
}  // namespace scanknit
