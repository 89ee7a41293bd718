// Surfaces that were cut are whole again, and others are left as they are.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "export/spill/stitch_borders.h"
#include "tests/export/texture_samples.h"

namespace scanknit {
namespace {

/// Two triangles with a common edge from (0,0,0) to (1,0,0), each with vertices of its own; all have one colour.
Mesh two_triangles() {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, -1, 0}};
  mesh.colours.assign(6, Rgb8{1, 2, 3});
  mesh.normals.assign(6, Eigen::Vector3f(0, 0, 1));
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

AppendedParts two_parts() {
  return {{0, 3}, 0, std::vector<Eigen::Vector2f>(6, Eigen::Vector2f::Zero())};
}

TEST(StitchParts, EqualEndsOfAnEdgeBecomeOne) {
  Mesh mesh = two_triangles();
  EXPECT_EQ(stitch_parts(mesh, two_parts()), 2u);
  EXPECT_EQ(mesh.positions_m.size(), 4u);
  EXPECT_TRUE(mesh.triangles == (std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}));
  EXPECT_EQ(mesh.positions_m[3], Eigen::Vector3f(0, -1, 0));
  EXPECT_EQ(check_mesh(mesh).boundary_edges, 4u);
}

TEST(StitchParts, WhatDiffersInAnythingStaysApart) {
  const auto joined = [](auto change) {
    Mesh mesh = two_triangles();
    AppendedParts parts = two_parts();
    change(mesh, parts);
    return stitch_parts(mesh, parts);
  };
  EXPECT_EQ(joined([](Mesh& mesh, AppendedParts&) { mesh.positions_m[3].x() = std::nextafter(1.0f, 2.0f); }), 0u);
  EXPECT_EQ(joined([](Mesh& mesh, AppendedParts&) { mesh.normals[3] = {0, 1, 0}; }), 0u);
  EXPECT_EQ(joined([](Mesh& mesh, AppendedParts&) { ++mesh.colours[3].b; }), 0u);
  EXPECT_EQ(joined([](Mesh&, AppendedParts& parts) { parts.coordinates[3].y() = 0.5f; }), 0u);
  EXPECT_EQ(joined([](Mesh& mesh, AppendedParts&) { std::swap(mesh.triangles[1][0], mesh.triangles[1][1]); }), 0u);
  EXPECT_EQ(joined([](Mesh&, AppendedParts& parts) { parts.first_vertex = {0}; }), 0u);
  EXPECT_EQ(joined([](Mesh& mesh, AppendedParts&) { mesh.normals.clear(); }), 2u);
}

TEST(StitchParts, WhatWasThereBeforeIsLeftAlone) {
  Mesh mesh = two_triangles(), more = two_triangles();
  for (const auto& [a, b, c] : more.triangles) mesh.triangles.emplace_back(a + 6, b + 6, c + 6);
  mesh.positions_m.insert(mesh.positions_m.end(), more.positions_m.begin(), more.positions_m.end());
  mesh.normals.resize(12, mesh.normals[0]);
  mesh.colours.resize(12, mesh.colours[0]);
  EXPECT_EQ(stitch_parts(mesh, {{6, 9}, 2, {}}), 2u);
  EXPECT_EQ(mesh.positions_m.size(), 10u);
  EXPECT_TRUE(check_mesh(mesh).is_well_formed);
  EXPECT_TRUE(std::equal(mesh.triangles.begin(), mesh.triangles.begin() + 2, two_triangles().triangles.begin()));
}

TEST(StitchParts, TwoVerticesOfOnePartStayTwo) {
  Mesh mesh = two_triangles();
  mesh.positions_m.insert(mesh.positions_m.end(), {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}});  // a third at the same edge
  mesh.normals.resize(9, mesh.normals[0]);
  mesh.colours.resize(9, mesh.colours[0]);
  mesh.triangles.emplace_back(6, 7, 8);
  Mesh other = mesh;
  EXPECT_EQ(stitch_parts(mesh, {{0, 3}, 0, {}}), 2u);  // with the first or with the third, not with both
  EXPECT_EQ(check_mesh(mesh).non_manifold_edges, 0u);
  EXPECT_EQ(stitch_parts(other, {{0, 3, 6}, 0, {}}), 2u);
  EXPECT_EQ(check_mesh(other).non_manifold_edges, 0u);
}

/// Every triangle in a part of its own, round one vertex: more than are believed.
TEST(StitchParts, AVertexOfVeryManyPartsIsAnswered) {
  constexpr int kParts = 20'000;
  Mesh mesh;
  AppendedParts parts;
  const auto rim = [](int i) {
    const double a = 2 * std::numbers::pi * (i % kParts) / kParts;
    return Eigen::Vector3d(std::cos(a), std::sin(a), 0).cast<float>().eval();
  };
  for (int i = 0; i < kParts; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
    parts.first_vertex.push_back(first);
    mesh.positions_m.insert(mesh.positions_m.end(), {Eigen::Vector3f::Zero(), rim(i), rim(i + 1)});
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  EXPECT_GT(stitch_parts(mesh, parts), 0u);
  EXPECT_TRUE(check_mesh(mesh).is_well_formed);
  EXPECT_EQ(check_mesh(mesh).non_manifold_edges, 0u);
}

TEST(StitchSeams, AClosedSurfaceUnfoldedIsClosed) {
  const Mesh sphere = test::sphere();
  Mesh mesh = test::atlas_of(sphere, 0.02).unfolded(sphere);
  ASSERT_FALSE(check_mesh(mesh).is_closed());
  const std::size_t seams = mesh.positions_m.size() - sphere.positions_m.size();
  EXPECT_EQ(stitch_seams(mesh).vertices, seams);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_closed() && check.is_manifold());
  EXPECT_EQ(check.euler, 2);
  EXPECT_EQ(check.components, 1u);
}

TEST(StitchSeams, AnOpenSurfaceUnfoldedIsAsOpenAsItWas) {
  for (const std::size_t holes : {1u, 2u, 7u}) {
    Mesh sphere = test::sphere();
    for (std::size_t i = 0; i < holes; ++i) {
      sphere.triangles.erase(sphere.triangles.begin() + static_cast<std::ptrdiff_t>(1000 + 500 * i));
    }
    Mesh mesh = test::atlas_of(sphere, 0.02).unfolded(sphere);
    stitch_seams(mesh);
    EXPECT_EQ(check_mesh(mesh).boundary_edges, 3 * holes);
  }
}

/// Rounding puts vertices of small triangles onto one another: borders are followed from where it is plain which belong
/// together, and what is guessed is told.
TEST(StitchSeams, ARoundedSurfaceIsClosedUnlessItSaysThatItGuessed) {
  const Mesh sphere = test::sphere();
  const Mesh unfolded = test::atlas_of(sphere, 0.02).unfolded(sphere);
  std::size_t collapsed = 0;
  for (const float step_m : {0.002f, 0.01f, 0.02f, 0.05f}) {
    Mesh mesh = unfolded;
    for (Eigen::Vector3f& p : mesh.positions_m) p = (p / step_m).array().round().matrix() * step_m;
    collapsed += check_mesh(mesh).degenerate_triangles;
    const StitchedSeams seams = stitch_seams(mesh);
    if (seams.guesses > 0) continue;
    EXPECT_EQ(seams.vertices, unfolded.positions_m.size() - sphere.positions_m.size()) << step_m;
    EXPECT_EQ(check_mesh(mesh).euler, 2) << step_m;
  }
  EXPECT_GT(collapsed, 0u) << "nothing was rounded away";
}

TEST(StitchSeams, NothingIsDoneToAClosedMeshOrToNone) {
  Mesh mesh = test::torus(), none;
  EXPECT_EQ(stitch_seams(mesh).vertices, 0u);
  EXPECT_EQ(stitch_seams(none).vertices, 0u);
  EXPECT_TRUE(check_mesh(mesh).is_closed());
}

}  // namespace
}  // namespace scanknit
