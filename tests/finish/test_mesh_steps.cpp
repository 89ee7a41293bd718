// What is done to a mesh: pieces, smoothing, simplifying, placing.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <iostream>
#include <random>
#include <stop_token>

#include "finish/mesh_edges.h"
#include "finish/mesh_steps.h"
#include "tests/core/sample_meshes.h"

namespace scanknit {
namespace {

void add(const Mesh& part, float scale, const Eigen::Vector3f& to, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const auto& p : part.positions_m) mesh.positions_m.push_back(scale * p + to);
  for (const Triangle& t : part.triangles) mesh.triangles.emplace_back(first + t[0], first + t[1], first + t[2]);
}

Mesh large_and_two_small() {
  Mesh mesh;
  add(test::tetrahedron(), 0.01f, {5, 0, 0}, mesh);
  add(test::sphere(), 1.0f, {0, 0, 0}, mesh);
  add(test::cube(), 0.2f, {0, 5, 0}, mesh);
  return mesh;
}

TEST(Pieces, BelowAShareOfTheLargestAreLeftOut) {
  Mesh mesh = large_and_two_small();
  const PiecesRemoved removed = remove_small_pieces(0.01, 0, mesh);  // the sphere has 12.5, the cube 0.96
  EXPECT_EQ(removed.pieces, 1u);
  EXPECT_EQ(removed.triangles, 4u);
  EXPECT_EQ(check_mesh(mesh).components, 2u);
  EXPECT_EQ(check_mesh(mesh).unreferenced_vertices, 0u);
}

TEST(Pieces, BelowASizeAreLeftOut) {
  Mesh mesh = large_and_two_small();
  const PiecesRemoved removed = remove_small_pieces(0, 0.7, mesh);  // the cube's diagonal is 0.693
  EXPECT_EQ(removed.pieces, 2u);
  EXPECT_NEAR(removed.area_m2, 0.96, 0.01);
  EXPECT_EQ(mesh.triangles.size(), test::sphere().triangles.size());
}

TEST(Pieces, OfTrianglesThatAreLeftOutWholePiecesAreCounted) {
  const Mesh mesh = large_and_two_small();
  std::vector<std::uint8_t> is_left_out(mesh.triangles.size());
  std::fill_n(is_left_out.begin(), 5, std::uint8_t{1});    // the tetrahedron, and one triangle of the sphere
  std::fill_n(is_left_out.rbegin(), 12, std::uint8_t{1});  // the cube
  const PiecesRemoved removed = count_removed(mesh, is_left_out);
  EXPECT_EQ(removed.pieces, 2u);
  EXPECT_EQ(removed.triangles, 17u);
  EXPECT_NEAR(removed.area_m2, 0.96, 0.96 * 0.1);  // 0.96 of a cube of 0.4, the others are small
}

TEST(Pieces, TheLargestStaysHoweverSmall) {
  Mesh mesh = test::tetrahedron();
  EXPECT_EQ(remove_small_pieces(1, 100, mesh).pieces, 0u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
}

TEST(MeshEdges, FansThatMeetInAVertexAreSplit) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  ASSERT_EQ(check_mesh(mesh).non_manifold_vertices, 1u);
  split_fans(mesh);
  EXPECT_EQ(check_mesh(mesh).non_manifold_vertices, 0u);
  EXPECT_EQ(mesh.positions_m.size(), 6u);
  EXPECT_EQ(check_mesh(mesh).components, 2u);
}

/// A ball of radius 1 whose vertices are off by some 1 % along the normal.
void roughen(Mesh& mesh, float sigma = 0.01f) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, sigma);
  for (auto& p : mesh.positions_m) p *= 1 + noise(random);
}

Mesh rough_ball(float sigma = 0.01f) {
  Mesh mesh = test::sphere(60, 120);
  roughen(mesh, sigma);
  return mesh;
}

double roughness(const Mesh& mesh) {
  double sum = 0;
  for (const auto& p : mesh.positions_m) sum += std::pow(static_cast<double>(p.norm()) - 1, 2);
  return std::sqrt(sum / static_cast<double>(mesh.positions_m.size()));
}

TEST(SmoothMesh, EvensOutNoiseAndKeepsTheVolume) {
  Mesh mesh = rough_ball();
  const double before = roughness(mesh);
  const double volume = signed_volume_m3(mesh);
  const MeshMoved moved = smooth_mesh(10, mesh);
  std::cout << "rms " << before << " -> " << roughness(mesh) << ", volume " << volume << " -> "
            << signed_volume_m3(mesh) << "\n";
  EXPECT_LT(roughness(mesh), 0.6 * before);
  EXPECT_NEAR(signed_volume_m3(mesh) / volume, 1, 0.005);
  EXPECT_GT(moved.mean_m, 0);
  EXPECT_GE(moved.max_m, moved.mean_m);
}

/// One of them ten times as large.
Mesh two_rough_balls() {
  Mesh mesh;
  add(rough_ball(), 1, {0, 0, 0}, mesh);
  add(rough_ball(), 10, {50, 0, 0}, mesh);
  return mesh;
}

/// Of the first and of the second half of its triangles.
std::array<double, 2> volumes_of_halves(const Mesh& mesh) {
  std::array<double, 2> volumes{};
  const auto half = static_cast<std::ptrdiff_t>(mesh.triangles.size() / 2);
  for (std::size_t i = 0; i < 2; ++i) {
    Mesh part = mesh;
    part.triangles.assign(mesh.triangles.begin() + (i == 0 ? 0 : half),
                          i == 0 ? mesh.triangles.begin() + half : mesh.triangles.end());
    volumes[i] = signed_volume_m3(part);
  }
  return volumes;
}

TEST(SmoothMesh, KeepsTheVolumeOfEachPieceOverHundredsOfSteps) {
  for (const std::size_t steps : {1, 15, 300, 1000}) {
    Mesh mesh = two_rough_balls();
    const auto before = volumes_of_halves(mesh);
    smooth_mesh(steps, mesh);
    const auto after = volumes_of_halves(mesh);
    constexpr double kOfFloats = 1e-5;
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(after[i] / before[i], 1, kOfFloats) << steps;
    EXPECT_TRUE(check_mesh(mesh).is_closed());
  }
}

TEST(SmoothMesh, StoppedItLeavesTheMeshAsItWas) {
  std::stop_source source;
  source.request_stop();
  Mesh mesh = rough_ball();
  const Mesh before = mesh;
  EXPECT_TRUE(smooth_mesh(1000, mesh, source.get_token()).is_stopped);
  EXPECT_TRUE(mesh.positions_m == before.positions_m);
  EXPECT_FALSE(smooth_mesh(1, mesh).is_stopped);
}

TEST(SmoothMesh, LeavesBoundariesWhereTheyAre) {
  Mesh mesh = rough_ball();
  mesh.triangles.resize(mesh.triangles.size() / 2);
  const Mesh before = mesh;
  smooth_mesh(5, mesh);
  for_each_edge(edge_sides(mesh), [&](std::span<const EdgeSide> edge) {
    if (edge.size() == 1) {
      EXPECT_TRUE(mesh.positions_m[edge[0].low] == before.positions_m[edge[0].low]);
    }
  });
}

TEST(SmoothMesh, IsTheSameBitsForOneTwoAndEightThreads) {
  std::vector<Mesh> meshes;
  for (const std::size_t threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    meshes.push_back(rough_ball());
    smooth_mesh(4, meshes.back());
  }
  EXPECT_TRUE(meshes[1].positions_m == meshes[0].positions_m);
  EXPECT_TRUE(meshes[2].positions_m == meshes[0].positions_m);
}

TEST(SimplifyMesh, ToANumberOfTrianglesKeepsTheTopology) {
  for (Mesh mesh : {test::torus(120, 60), rough_ball()}) {
    const MeshCheck before = check_mesh(mesh);
    const MeshSimplified done = simplify_mesh({.triangles = 1500, .max_error_m = {}}, mesh);
    const MeshCheck after = check_mesh(mesh);
    EXPECT_EQ(done.triangles, mesh.triangles.size());
    std::cout << done.triangles_before << " -> " << done.triangles << " triangles\n";
    EXPECT_LT(mesh.triangles.size(), 2600u);
    EXPECT_TRUE(after.is_closed());
    EXPECT_TRUE(after.is_manifold());
    EXPECT_EQ(after.euler, before.euler);
    EXPECT_EQ(after.unreferenced_vertices, 0u);
  }
}

constexpr float kSpiky = 0.06f;  // so rough that collapses go wrong

TEST(SimplifyMesh, WhatGoesWrongAtOnceIsDoneInSteps) {
  for (const std::size_t wished : {60u, 150u, 400u}) {
    Mesh mesh = test::torus(300, 60);
    for (auto& p : mesh.positions_m) p = p.cwiseProduct(Eigen::Vector3f(1, 1, 0.01f));  // a ring of paper
    roughen(mesh);
    const MeshSimplified done = simplify_mesh({.triangles = wished, .max_error_m = {}}, mesh);
    const MeshCheck after = check_mesh(mesh);
    std::cout << wished << " wished, " << done.triangles << " triangles, " << done.error_m << " m off\n";
    EXPECT_LT(done.triangles, 2 * wished);
    EXPECT_TRUE(after.is_closed() && after.is_manifold());
    EXPECT_EQ(after.components, 1u);
  }
}

TEST(SimplifyMesh, ALargerErrorDoesNotLeaveMoreTriangles) {
  std::size_t last = rough_ball(kSpiky).triangles.size();
  for (const double error_m : {0.01, 0.03, 0.1, 0.3, 1.0, 10.0}) {
    Mesh mesh = rough_ball(kSpiky);
    const MeshSimplified done = simplify_mesh({.triangles = {}, .max_error_m = error_m}, mesh);
    std::cout << error_m << " m allowed, " << done.triangles << " triangles, " << done.error_m << " m off\n";
    EXPECT_LE(done.error_m, error_m * (1 + 1e-6));
    EXPECT_LT(done.triangles, last + last / 2);  // in steps a little less is won than at once
    EXPECT_TRUE(check_mesh(mesh).is_closed());
    last = std::min(last, done.triangles);
  }
}

TEST(SimplifyMesh, SmallPiecesMayVanishButNoRingDoes) {
  Mesh mesh = test::torus(120, 60);
  const Mesh crumb = test::sphere(8, 16);
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const Eigen::Vector3f& p : crumb.positions_m) mesh.positions_m.push_back(Eigen::Vector3f(9, 0, 0) + 0.001f * p);
  for (const Triangle& t : crumb.triangles) mesh.triangles.emplace_back(t[0] + first, t[1] + first, t[2] + first);
  ASSERT_EQ(check_mesh(mesh).components, 2u);
  const MeshSimplified done = simplify_mesh({.triangles = 500, .max_error_m = {}}, mesh);
  const MeshCheck after = check_mesh(mesh);
  EXPECT_LT(mesh.triangles.size(), 600u);
  EXPECT_FALSE(done.is_held_back);
  EXPECT_EQ(done.pieces_lost, 1u);
  EXPECT_EQ(after.components, 1u);
  EXPECT_EQ(after.euler, 0);
  EXPECT_TRUE(after.is_closed() && after.is_manifold());
}

TEST(SimplifyMesh, ToAnErrorStaysWithinIt) {
  Mesh mesh = test::sphere(96, 192);
  const MeshSimplified done = simplify_mesh({.triangles = {}, .max_error_m = 0.002}, mesh);
  EXPECT_LT(mesh.triangles.size(), done.triangles_before / 4);
  EXPECT_LE(done.error_m, 0.002);
  double farthest = 0;  // middles of triangles lie deepest within the ball
  for (const Triangle& t : mesh.triangles) {
    const Eigen::Vector3f middle = (mesh.positions_m[t[0]] + mesh.positions_m[t[1]] + mesh.positions_m[t[2]]) / 3;
    farthest = std::max(farthest, 1 - static_cast<double>(middle.norm()));
  }
  std::cout << mesh.triangles.size() << " triangles, " << farthest << " off\n";
  EXPECT_LT(farthest,
            3 * 0.002);  // the quadrics' error is a mean over the planes of a vertex, not the largest distance
}

TEST(SimplifyMesh, LeavesAMeshThatIsSmallEnough) {
  Mesh mesh = test::torus();
  const Mesh before = mesh;
  const MeshSimplified done = simplify_mesh({.triangles = 100'000, .max_error_m = {}}, mesh);
  EXPECT_EQ(done.triangles, before.triangles.size());
  EXPECT_TRUE(mesh.positions_m == before.positions_m);
}

TEST(SimplifyMesh, VerticesKeepTheirColour) {
  Mesh mesh = test::sphere(60, 120);
  for (const auto& p : mesh.positions_m) mesh.colours.push_back(p.z() > 0 ? Rgb8{255, 0, 0} : Rgb8{0, 0, 255});
  (void)simplify_mesh({.triangles = 800, .max_error_m = {}}, mesh);
  ASSERT_EQ(mesh.colours.size(), mesh.positions_m.size());
  for (std::size_t i = 0; i < mesh.colours.size(); ++i) {
    EXPECT_EQ(mesh.colours[i].r, mesh.positions_m[i].z() > 0 ? 255 : 0);
  }
}

TEST(PlaceMesh, StandsOnTheOriginTheRightWayUp) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.2, 0.3, 0.9).normalized();
  const Eigen::Vector3d wanted(0, -1, 0);
  Mesh mesh = test::cube();
  mesh.normals.assign(8, up.cast<float>());
  const Pose turned = turn_up(up, wanted);
  transform_mesh(turned, mesh);
  transform_mesh(stand_on_origin(mesh, wanted), mesh);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_NEAR(check.max_m.y(), 0, 1e-6);  // -y is up: the lowest vertex has the largest y
  EXPECT_LT(check.min_m.y(), -1);
  EXPECT_NEAR(check.min_m.x(), -check.max_m.x(), 1e-6);
  EXPECT_NEAR(check.min_m.z(), -check.max_m.z(), 1e-6);
  EXPECT_NEAR((mesh.normals[3].cast<double>() - wanted).norm(), 0, 1e-6);
  EXPECT_NEAR(signed_volume_m3(mesh), 8, 1e-5);
}

}  // namespace
}  // namespace scanknit
