// An array of samples gives the surface that the same samples give in an OpenVDB grid, whatever its size and transform.
#include "extract/blocks/dense_blocks.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Box;

Box noise(const Eigen::Vector3i& dims, unsigned seed, unsigned holes_one_in = 0) {
  std::mt19937 random(seed);
  Box box(dims);
  for (float& sample : box.samples) {
    sample = static_cast<float>(random()) / 2147483648.0f - 1.0f;
    if (holes_one_in > 0 && random() % holes_one_in == 0) sample = test::kNaN;
  }
  return box;
}

/// Index (i, j, k); or (k, j, i), as blocks of an array count, and a transform that undoes it.
openvdb::FloatGrid::Ptr grid_of(Box& box, bool with_axes_reversed) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  auto accessor = grid->getAccessor();
  for (int i = 0; i < box.dims.x(); ++i) {
    for (int j = 0; j < box.dims.y(); ++j) {
      for (int k = 0; k < box.dims.z(); ++k)
        accessor.setValueOn(with_axes_reversed ? openvdb::Coord(k, j, i) : openvdb::Coord(i, j, k), box.at(i, j, k));
    }
  }
  const openvdb::Mat4d swap_x_and_z(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1);
  if (with_axes_reversed) grid->setTransform(openvdb::math::Transform::createLinearTransform(swap_x_and_z));
  return grid;
}

using Point = std::array<float, 3>;

/// Of every triangle its corners by position, from the least on, which does not change the winding; sorted.
std::vector<std::array<Point, 3>> triangles_of(const Mesh& mesh) {
  std::vector<std::array<Point, 3>> triangles;
  for (const Triangle& t : mesh.triangles) {
    std::array<Point, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f& p = mesh.positions_m[t[i]];
      corners[i] = {p.x(), p.y(), p.z()};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// The vertices on grid edges, sorted.
std::vector<Point> points_on_edges(const Mesh& mesh) {
  std::vector<Point> points;
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    if ((p.array() == p.array().round()).count() >= 2) points.push_back({p.x(), p.y(), p.z()});
  }
  std::sort(points.begin(), points.end());
  return points;
}

/// A cell seen in a mirror is the same surface, but may be cut into other triangles: exactly the same ones with the
/// axes reversed, the same vertices and invariants without.
void expect_like_openvdb(Box box) {
  SCOPED_TRACE(::testing::Message() << box.dims.transpose());
  ExtractConfig config;
  config.inside = InsideSide::kHigh;
  const Surface array = test::extract(box, config);
  const MeshCheck check = check_mesh(array.mesh);
  test::expect_manifold(check);
  const auto reversed = grid_of(box, true);
  const Surface same = extract_surface(test::view_of(*reversed), config).value();
  EXPECT_TRUE(triangles_of(array.mesh) == triangles_of(same.mesh));
  const auto grid = grid_of(box, false);
  const Surface mirrored = extract_surface(test::view_of(*grid), config).value();
  EXPECT_EQ(points_on_edges(array.mesh), points_on_edges(mirrored.mesh));
  EXPECT_EQ(check.triangles, mirrored.mesh.triangles.size());
  EXPECT_EQ(check.euler, check_mesh(mirrored.mesh).euler);
  EXPECT_EQ(check.components, check_mesh(mirrored.mesh).components);
}

TEST(DenseBlocks, GiveTheTrianglesOfAnOpenVdbGrid) {
  for (const Eigen::Vector3i& dims :
       {Eigen::Vector3i(1, 1, 1), Eigen::Vector3i(1, 7, 9), Eigen::Vector3i(9, 1, 4), Eigen::Vector3i(12, 5, 1),
        Eigen::Vector3i(2, 2, 2), Eigen::Vector3i(8, 8, 8), Eigen::Vector3i(9, 8, 7), Eigen::Vector3i(7, 9, 8),
        Eigen::Vector3i(16, 9, 10), Eigen::Vector3i(17, 33, 5), Eigen::Vector3i(24, 24, 24), Eigen::Vector3i(2, 40, 3)})
    expect_like_openvdb(noise(dims, 1));
}

TEST(DenseBlocks, GiveThemWithHolesToo) {
  for (const unsigned one_in : {100u, 10u, 3u}) {
    expect_like_openvdb(noise({9, 8, 7}, one_in, one_in));
    expect_like_openvdb(noise({17, 33, 5}, one_in, one_in));
    expect_like_openvdb(noise({23, 10, 19}, one_in, one_in));
  }
}

TEST(DenseBlocks, CountTheCasesOfAnOpenVdbGrid) {
  Box box = noise({17, 33, 5}, 5, 20);
  const auto grid = grid_of(box, false);
  const CaseCounts counts = test::extract(box).cases;
  const CaseCounts expected = extract_surface(test::view_of(*grid), {}).value().cases;
  ASSERT_EQ(counts.sub_cases.size(), expected.sub_cases.size());
  for (std::size_t i = 0; i < expected.sub_cases.size(); ++i)
    EXPECT_EQ(counts.sub_cases[i].cells, expected.sub_cases[i].cells) << expected.sub_cases[i].name;
  EXPECT_EQ(counts.ambiguous_faces_joined, expected.ambiguous_faces_joined);
  EXPECT_EQ(counts.ambiguous_faces_separated, expected.ambiguous_faces_separated);
  EXPECT_EQ(counts.tunnels, expected.tunnels);
  EXPECT_EQ(counts.skipped_cells, expected.skipped_cells);
}

TEST(DenseBlocks, OfFewerThanTwoSamplesAlongAnAxisHaveNoSurface) {
  for (const Eigen::Vector3i& dims :
       {Eigen::Vector3i(1, 1, 1), Eigen::Vector3i(1, 30, 20), Eigen::Vector3i(30, 20, 1)}) {
    const Surface surface = test::extract(noise(dims, 2));
    EXPECT_TRUE(surface.mesh.empty());
    EXPECT_TRUE(surface.mesh.positions_m.empty());
  }
}

TEST(DenseBlocks, TakeHugeUnobservedRegions) {
  Box box({70, 60, 50}, test::kNaN);
  const Box ball = noise({5, 5, 5}, 3);
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      for (int k = 0; k < 5; ++k) box.at(37 + i, 30 + j, 14 + k) = Box(ball).at(i, j, k);
    }
  }
  const MeshCheck expected = check_mesh(test::extract(ball).mesh);
  const MeshCheck check = check_mesh(test::extract(box).mesh);
  ASSERT_GT(expected.triangles, 0u);
  EXPECT_EQ(check.triangles, expected.triangles);
  EXPECT_EQ(check.vertices, expected.vertices);
  EXPECT_EQ(check.boundary_edges, expected.boundary_edges);
  EXPECT_EQ(check.euler, expected.euler);
  expect_like_openvdb(box);
}

TEST(DenseBlocks, AllUnobservedHaveNoSurface) {
  EXPECT_TRUE(test::extract(Box({20, 20, 20}, test::kNaN)).mesh.empty());
}

constexpr double kRadius = 6.5;
constexpr double kBallVolume = 4.0 / 3.0 * std::numbers::pi * kRadius * kRadius * kRadius;
constexpr double kChordError = 0.03 * kBallVolume;  // chords of one voxel lie below the arc: some 3 h^2 / (4 R^2)

Mesh ball(const Eigen::Affine3d& T_world_ijk) {
  Box box({18, 17, 19});
  for (int i = 0; i < 18; ++i) {
    for (int j = 0; j < 17; ++j) {
      for (int k = 0; k < 19; ++k)  // matter is High: what kAuto means for arrays
        box.at(i, j, k) = static_cast<float>(kRadius - Eigen::Vector3d(i - 8.3, j - 7.9, k - 9.4).norm());
    }
  }
  return test::extract(box, {}, T_world_ijk).mesh;
}

/// The volume in the world is that in index space times |det|, and positive: triangles face outwards.
void expect_ball(const Eigen::Matrix3d& linear) {
  Eigen::Affine3d T_world_ijk = Eigen::Affine3d::Identity();
  T_world_ijk.linear() = linear;
  T_world_ijk.translation() << 5, -3, 20;
  const Mesh mesh = ball(T_world_ijk);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_EQ(check.euler, 2);
  const double stretch = std::abs(linear.determinant());
  EXPECT_NEAR(signed_volume_m3(mesh), stretch * kBallVolume, stretch * kChordError);
}

TEST(DenseBlocks, LieWhereTheTransformSays) {
  Eigen::Affine3d T_world_ijk = Eigen::Affine3d::Identity();
  T_world_ijk.linear() = Eigen::Vector3d(2, 3, 0.5).asDiagonal();
  T_world_ijk.translation() << 5, -3, 20;
  const Eigen::Vector3d centre = T_world_ijk * Eigen::Vector3d(8.3, 7.9, 9.4);
  const MeshCheck check = check_mesh(ball(T_world_ijk));
  const Eigen::Vector3d half_size = kRadius * Eigen::Vector3d(2, 3, 0.5);
  constexpr double kHalfVoxel = 0.5;  // no vertex need lie at the very end
  for (int axis = 0; axis < 3; ++axis) {
    const double tolerance = kHalfVoxel * T_world_ijk.linear()(axis, axis);
    EXPECT_NEAR(static_cast<double>(check.min_m[axis]), centre[axis] - half_size[axis], tolerance);
    EXPECT_NEAR(static_cast<double>(check.max_m[axis]), centre[axis] + half_size[axis], tolerance);
  }
}

TEST(DenseBlocks, FaceOutwardsUnderAnisotropicSpacing) {
  expect_ball(Eigen::Vector3d(0.3, 1, 2.5).asDiagonal());
}

TEST(DenseBlocks, FaceOutwardsInAMirror) {
  expect_ball(Eigen::Vector3d(-1, 1, 1).asDiagonal());
  expect_ball(Eigen::Vector3d(1, -1, 2).asDiagonal());
  expect_ball(Eigen::Vector3d(-1, -1, -0.5).asDiagonal());
}

TEST(DenseBlocks, FaceOutwardsWithAxesExchangedTurnedOrSheared) {
  Eigen::Matrix3d exchanged;
  exchanged << 0, 1, 0, 1, 0, 0, 0, 0, 1;
  expect_ball(exchanged);
  expect_ball(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix());
  Eigen::Matrix3d sheared;
  sheared << 1, 0.4, 0, 0, 1, 0.3, 0, 0, 1;
  expect_ball(sheared);
}

TEST(DenseBlocks, NormalsFaceOutwardsWithTheTriangles) {
  const Mesh mesh = ball(Eigen::Affine3d(Eigen::Scaling(-1.0, 0.5, 2.0)));
  const Eigen::Vector3f centre(-8.3f, 0.5f * 7.9f, 2 * 9.4f);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) ASSERT_GT(mesh.normals[i].dot(mesh.positions_m[i] - centre), 0);
}

TEST(DenseBlocks, GiveTheSameBitsForAnyNumberOfThreads) {
  const Box box = noise({50, 33, 41}, 4, 30);
  const auto extract_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return test::extract(box).mesh;
  };
  const Mesh one = extract_with(1);
  for (const std::size_t threads : {std::size_t{2}, std::size_t{8}}) test::expect_same_bits(extract_with(threads), one);
}

ErrorCode error_of(const DenseView& view) {
  const Result<Surface> surface = extract_surface(view, {});
  return surface ? ErrorCode::kInternal : surface.error().code;
}

TEST(DenseBlocks, RefuseSizesWithoutSamples) {
  const float sample = 0;
  for (const Eigen::Vector3i& dims : {Eigen::Vector3i(0, 2, 2), Eigen::Vector3i(2, -1, 2), Eigen::Vector3i(2, 2, 0),
                                      Eigen::Vector3i(std::numeric_limits<int>::max(), 1, 1)})
    EXPECT_EQ(error_of({&sample, dims, Eigen::Affine3d::Identity()}), ErrorCode::kConfig) << dims.transpose();
}

TEST(DenseBlocks, RefuseTransformsThatCannotBeInvertedOrAreNoNumbers) {
  Box box({2, 2, 2});
  for (const double x :
       {0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e39}) {
    DenseView view{box.samples.data(), box.dims};
    view.T_world_ijk.linear()(0, 0) = x;
    EXPECT_EQ(error_of(view), ErrorCode::kConfig) << x;
  }
}

}  // namespace
}  // namespace scanknit
