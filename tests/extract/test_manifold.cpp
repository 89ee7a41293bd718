// The promise of this room: whatever the samples, the mesh is manifold, oriented, and ends only where the volume does.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstring>

#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

void expect_sound(const Dense& volume, const ExtractConfig& config = {}) {
  const Surface surface = test::extract(volume, config, {{-11, -5, 3}, 0.004, {0.3, -1.7, 2.5}});
  const MeshCheck check = check_mesh(surface.mesh);
  EXPECT_TRUE(check.is_well_formed);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(check.misoriented_edges, 0u);
  EXPECT_EQ(check.non_manifold_vertices, 0u);
  EXPECT_EQ(check.duplicate_triangles, 0u);
  EXPECT_EQ(check.unreferenced_vertices, 0u);
  EXPECT_EQ(check.boundary_edges, test::expected_boundary_edges(volume, static_cast<float>(config.isovalue)));
  constexpr float kUnitTolerance = 1e-5f;  // rounding of three floats
  for (const Eigen::Vector3f& normal : surface.mesh.normals) ASSERT_NEAR(normal.norm(), 1, kUnitTolerance);
}

std::size_t degenerate_triangles(const Dense& volume, const test::GridPlace& place) {
  return check_mesh(test::extract(volume, {}, place).mesh).degenerate_triangles;
}

class Manifold : public ::testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Seeds, Manifold, ::testing::Range(1u, 9u));

TEST_P(Manifold, WhiteNoise) {
  expect_sound(test::white_noise(24, GetParam()));
}

TEST_P(Manifold, NoiseOfThreeLevelsWithTies) {
  expect_sound(test::three_level_noise(24, GetParam()));
}

TEST_P(Manifold, NoiseWithFewHoles) {
  Dense volume = test::white_noise(24, GetParam());
  test::punch_holes(volume, 50, GetParam() + 100);
  expect_sound(volume);
}

TEST_P(Manifold, TiesWithManyHolesThatPinch) {
  Dense volume = test::three_level_noise(24, GetParam());
  test::punch_holes(volume, 6, GetParam() + 100);
  expect_sound(volume);
}

TEST_P(Manifold, MostlyUnobserved) {
  Dense volume = test::white_noise(24, GetParam());
  test::punch_holes(volume, 3, GetParam() + 100);
  expect_sound(volume);
}

TEST_P(Manifold, OtherIsovalueOfQuantisedNoise) {
  Dense volume = test::three_level_noise(20, GetParam());
  ExtractConfig config;
  config.isovalue = 1;
  expect_sound(volume, config);
}

TEST_P(Manifold, MidEdgePlacement) {
  ExtractConfig config;
  config.placement = VertexPlacement::kMidEdge;
  expect_sound(test::three_level_noise(20, GetParam()), config);
}

TEST(Manifold, HolesDoPinchVertices) {
  // Two whole cells left, opposite each other across the grid edge (4, 4, 4)-(4, 4, 5), which the surface crosses.
  Dense volume(9, test::kNaN);
  for (int i = 0; i < 2; ++i) {
    for (int x = 0; x < 2; ++x) {
      for (int y = 0; y < 2; ++y) {
        for (int z = 0; z < 2; ++z) volume.at(3 + i + x, 3 + i + y, 4 + z) = z == 0 ? -1.0f : 1.0f;
      }
    }
  }
  const Surface surface = test::extract(volume);
  const MeshCheck check = check_mesh(surface.mesh);
  EXPECT_EQ(check.vertices, 8u);  // 7 grid edges, one of them with two vertices
  EXPECT_EQ(check.components, 2u);
  EXPECT_EQ(check.non_manifold_vertices, 0u);
}

TEST(Manifold, PinchedVertexOnABlockBorderIsSplit) {
  for (int axis = 0; axis < 3; ++axis) {
    Dense volume(12, test::kNaN);
    for (int i = 0; i < 2; ++i) {
      for (int corner = 0; corner < 8; ++corner) {
        int p[3] = {7 + (corner & 1), 7 + ((corner >> 1) & 1), 7 + (corner >> 2)};
        p[(axis + 1) % 3] += i;
        p[(axis + 2) % 3] += 1 - i;
        volume.at(p[0], p[1], p[2]) = p[axis] == 7 ? -1.0f : 1.0f;
      }
    }
    const MeshCheck check = check_mesh(test::extract(volume).mesh);
    EXPECT_EQ(check.vertices, 8u) << axis;
    EXPECT_EQ(check.non_manifold_vertices, 0u) << axis;
  }
}

TEST(Manifold, SamplesOnTheIsovalueMakeNoDegenerateTriangle) {
  EXPECT_EQ(degenerate_triangles(test::three_level_noise(24, 1), {}), 0u);
}

TEST(Manifold, NorDoTheyFarFromTheOrigin) {
  EXPECT_EQ(degenerate_triangles(test::three_level_noise(16, 2), {{100000, -300000, 8000}, 0.001, {5, 0, -80}}), 0u);
}

TEST(Manifold, SameBitsForAnyNumberOfThreads) {
  Dense volume = test::white_noise(40, 5);
  test::punch_holes(volume, 30, 6);
  const auto extract_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return test::extract(volume, {}, {{-9, 4, 100}, 0.01, {}}).mesh;
  };
  const Mesh one = extract_with(1);
  for (const std::size_t threads : {std::size_t{2}, std::size_t{8}}) {
    const Mesh many = extract_with(threads);
    EXPECT_EQ(many.triangles, one.triangles);
    ASSERT_EQ(many.positions_m.size(), one.positions_m.size());
    const std::size_t bytes = one.positions_m.size() * sizeof(Eigen::Vector3f);
    EXPECT_EQ(std::memcmp(many.positions_m.data(), one.positions_m.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(many.normals.data(), one.normals.data(), bytes), 0);
  }
}

TEST(Manifold, SymmetriesOfTheCubeKeepTheInvariants) {
  constexpr int kSide = 14;
  const Dense volume = test::white_noise(kSide, 9);
  const MeshCheck expected = check_mesh(test::extract(volume).mesh);
  for (int symmetry = 0; symmetry < 48; ++symmetry) {
    constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    Dense moved(kSide);
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          const int from[3] = {x, y, z};
          int to[3];
          for (int axis = 0; axis < 3; ++axis) {
            const int c = from[kOrders[symmetry / 8][axis]];
            to[axis] = ((symmetry >> axis) & 1) != 0 ? kSide - 1 - c : c;
          }
          moved.at(to[0], to[1], to[2]) = volume.at(x, y, z);
        }
      }
    }
    const MeshCheck check = check_mesh(test::extract(moved).mesh);
    ASSERT_EQ(check.vertices, expected.vertices) << symmetry;
    ASSERT_EQ(check.triangles, expected.triangles) << symmetry;
    ASSERT_EQ(check.components, expected.components) << symmetry;
    ASSERT_EQ(check.boundary_edges, expected.boundary_edges) << symmetry;
    ASSERT_EQ(check.euler, expected.euler) << symmetry;
  }
}

}  // namespace
}  // namespace scanknit
