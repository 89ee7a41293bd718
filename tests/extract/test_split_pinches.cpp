// What becomes of vertices where parts of a mesh touch.
#include <gtest/gtest.h>

#include <random>

#include "extract/split_pinches.h"

namespace scanknit {
namespace {

/// Vertices at (0, 0, 0), (1, 1, 1), (2, 4, 8), ...: no two coincide.
Mesh mesh_of(std::size_t vertices, std::vector<Triangle> triangles) {
  Mesh mesh;
  for (std::size_t i = 0; i < vertices; ++i) {
    const auto x = static_cast<float>(i);
    mesh.positions_m.emplace_back(x, x * x, x * x * x);
  }
  mesh.triangles = std::move(triangles);
  return mesh;
}

Mesh bow_tie() {
  return mesh_of(5, {{0, 1, 2}, {0, 3, 4}});
}

TEST(SplitPinches, GivesEachFurtherFanACopy) {
  Mesh mesh = mesh_of(7, {{0, 1, 2}, {3, 0, 4}, {5, 6, 0}});
  EXPECT_EQ(split_pinched_vertices(mesh), 2u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 7, 4}, {5, 6, 8}}));
  EXPECT_EQ(mesh.positions_m[7], mesh.positions_m[0]);
  EXPECT_EQ(mesh.positions_m[8], mesh.positions_m[0]);
}

TEST(SplitPinches, CopiesNormalsAndColours) {
  Mesh mesh = bow_tie();
  mesh.normals.assign(5, Eigen::Vector3f::UnitX());
  mesh.normals[0] = Eigen::Vector3f::UnitZ();
  mesh.colours.assign(5, Rgb8{1, 2, 3});
  mesh.colours[0] = Rgb8{7, 8, 9};
  EXPECT_EQ(split_pinched_vertices(mesh), 1u);
  ASSERT_EQ(mesh.normals.size(), 6u);
  ASSERT_EQ(mesh.colours.size(), 6u);
  EXPECT_EQ(mesh.normals[5], mesh.normals[0]);
  EXPECT_EQ(mesh.colours[5], mesh.colours[0]);
}

TEST(SplitPinches, LeavesAFanInAnyOrderAlone) {
  // Four triangles round vertex 0, open between 4 and 1, the outer ones first: they join up late.
  const std::vector<Triangle> fan{{0, 1, 2}, {4, 5, 0}, {0, 3, 4}, {2, 3, 0}};
  Mesh mesh = mesh_of(6, fan);
  EXPECT_EQ(split_pinched_vertices(mesh), 0u);
  EXPECT_EQ(mesh.triangles, fan);
  EXPECT_EQ(mesh.positions_m.size(), 6u);
}

TEST(SplitPinches, ConnectsFansByEdgesAtTheVertexOnly) {
  Mesh mesh = mesh_of(5, {{0, 1, 2}, {0, 3, 4}, {1, 3, 2}});  // the third touches both, the second in a vertex
  EXPECT_EQ(split_pinched_vertices(mesh), 2u);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {5, 3, 4}, {1, 6, 2}}));
}

TEST(SplitPinches, LeavesAnEdgeOfThreeTrianglesWhole) {
  Mesh mesh = mesh_of(5, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  EXPECT_EQ(split_pinched_vertices(mesh), 0u);
}

TEST(SplitPinches, SplitsNeighboursOfSplitVertices) {
  // Two strips of two triangles each that touch at the ends of their common diagonals: 0 and 1.
  Mesh mesh = mesh_of(6, {{0, 1, 2}, {4, 0, 5}, {1, 0, 3}, {5, 1, 4}});
  EXPECT_EQ(split_pinched_vertices(mesh), 2u);
  EXPECT_EQ(check_mesh(mesh).non_manifold_vertices, 0u);
  EXPECT_EQ(check_mesh(mesh).components, 2u);
}

TEST(SplitPinches, EmptyMeshAndUnusedVerticesStay) {
  Mesh empty;
  EXPECT_EQ(split_pinched_vertices(empty), 0u);
  Mesh unused = mesh_of(4, {{1, 2, 3}});
  EXPECT_EQ(split_pinched_vertices(unused), 0u);
  EXPECT_EQ(unused.positions_m.size(), 4u);
}

TEST(SplitPinches, RandomTriangleSoupLosesItsPinchesAndNothingElse) {
  std::mt19937 random(11);
  for (int trial = 0; trial < 200; ++trial) {
    Mesh mesh = mesh_of(12, {});
    for (int i = 0; i < 10; ++i) {
      const auto a = static_cast<std::uint32_t>(random() % 12);
      const auto b = static_cast<std::uint32_t>((a + 1 + random() % 5) % 12);
      const auto c = static_cast<std::uint32_t>((b + 1 + random() % 5) % 12);
      mesh.triangles.push_back({a, b, c});
    }
    const Mesh before = mesh;
    const std::size_t copies = split_pinched_vertices(mesh);
    ASSERT_EQ(mesh.positions_m.size(), before.positions_m.size() + copies);
    const MeshCheck check = check_mesh(mesh);
    ASSERT_EQ(check.non_manifold_vertices, 0u);
    ASSERT_EQ(check.boundary_edges, check_mesh(before).boundary_edges);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i)
        ASSERT_EQ(mesh.positions_m[mesh.triangles[t][i]], before.positions_m[before.triangles[t][i]]);
    }
    ASSERT_EQ(split_pinched_vertices(mesh), 0u);
  }
}

}  // namespace
}  // namespace scanknit
