// The promise of this room: whatever the samples, the mesh is manifold, oriented, and ends only where the volume does.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <set>
#include <string>

#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

void expect_sound(const Dense& volume, const ExtractConfig& config = {}) {
  const Surface surface = test::extract(volume, config, {{-11, -5, 3}, 0.004, {0.3, -1.7, 2.5}});
  const MeshCheck check = check_mesh(surface.mesh);
  test::expect_manifold(check);
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

// Where the mean of a cell's vertices would lie in line with two of them.
TEST_P(Manifold, SymmetricCellsMakeNoDegenerateTriangle) {
  for (const double isovalue : {0.5, 0.25, 0.0}) {
    for (const VertexPlacement placement : {VertexPlacement::kLinear, VertexPlacement::kMidEdge}) {
      for (const Decider decider : {Decider::kTrilinear, Decider::kAsymptotic, Decider::kFixedLow}) {
        ExtractConfig config;
        config.isovalue = isovalue;
        config.placement = placement;
        config.decider = decider;
        EXPECT_EQ(check_mesh(test::extract(test::binary_noise(24, GetParam()), config).mesh).degenerate_triangles, 0u);
      }
    }
  }
}

TEST(Manifold, NorDoTheyFarFromTheOrigin) {
  EXPECT_EQ(degenerate_triangles(test::three_level_noise(16, 2), {{100000, -300000, 8000}, 0.001, {5, 0, -80}}), 0u);
}

TEST(Manifold, WhereFloatsAreTooCoarseTheVolumeIsRefused) {
  for (const double metres : {900.0, 1e4}) {
    const test::GridPlace place{{0, 0, 0}, 0.001, {0, metres, 0}};
    const auto grid = test::make_grid(test::white_noise(8, 1), place);
    const auto from_grid = extract_surface(test::view_of(*grid), {});
    EXPECT_EQ(from_grid.has_value(), metres < 1000);

    const test::Box box(test::white_noise(8, 1));
    Eigen::Affine3d T_world_ijk(Eigen::Translation3d(0, metres, 0) * Eigen::Scaling(0.001));
    const auto from_array = extract_surface(DenseView{box.samples.data(), box.dims, T_world_ijk}, {});
    EXPECT_EQ(from_array.has_value(), metres < 1000);
    EXPECT_TRUE(from_array || from_array.error().message.find("origin") != std::string::npos);
  }
}

class Equivariance : public ::testing::TestWithParam<Decider> {
 protected:
  static ExtractConfig config() {
    ExtractConfig config;
    config.decider = GetParam();
    config.inside = InsideSide::kHigh;
    return config;
  }
};
std::string name_of(Decider decider) {
  switch (decider) {
    case Decider::kTrilinear: return "trilinear";
    case Decider::kAsymptotic: return "asymptotic";
    case Decider::kChord: return "chord";
    default: return "knit";
  }
}
INSTANTIATE_TEST_SUITE_P(Deciders, Equivariance,
                         ::testing::Values(Decider::kTrilinear, Decider::kAsymptotic, Decider::kChord, Decider::kKnit),
                         [](const auto& test) { return name_of(test.param); });

TEST_P(Equivariance, SameBitsForAnyNumberOfThreads) {
  Dense volume = test::white_noise(40, 5);
  test::punch_holes(volume, 30, 6);
  const auto extract_with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return test::extract(volume, config(), {{-9, 4, 100}, 0.01, {}}).mesh;
  };
  const Mesh one = extract_with(1);
  for (const std::size_t threads : {std::size_t{2}, std::size_t{8}}) test::expect_same_bits(extract_with(threads), one);
}

/// The sample at `from` goes where one of the 48 symmetries of the cube takes it.
Eigen::Vector3i moved(const Eigen::Vector3i& from, int symmetry, int side) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  Eigen::Vector3i to;
  for (int axis = 0; axis < 3; ++axis) {
    const int c = from[kOrders[symmetry / 8][axis]];
    to[axis] = ((symmetry >> axis) & 1) != 0 ? side - 1 - c : c;
  }
  return to;
}

TEST_P(Equivariance, SymmetriesOfTheCubeKeepTheInvariants) {
  constexpr int kSide = 14;
  for (const Dense& volume : {test::white_noise(kSide, 9), test::three_level_noise(kSide, 9)}) {
    const MeshCheck expected = check_mesh(test::extract(volume, config()).mesh);
    for (int symmetry = 0; symmetry < 48; ++symmetry) {
      Dense turned(kSide);
      for (int x = 0; x < kSide; ++x) {
        for (int y = 0; y < kSide; ++y) {
          for (int z = 0; z < kSide; ++z) {
            const Eigen::Vector3i to = moved({x, y, z}, symmetry, kSide);
            turned.at(to.x(), to.y(), to.z()) = volume.at(x, y, z);
          }
        }
      }
      const MeshCheck check = check_mesh(test::extract(turned, config()).mesh);
      ASSERT_EQ(check.vertices, expected.vertices) << symmetry;
      ASSERT_EQ(check.triangles, expected.triangles) << symmetry;
      ASSERT_EQ(check.components, expected.components) << symmetry;
      ASSERT_EQ(check.boundary_edges, expected.boundary_edges) << symmetry;
      ASSERT_EQ(check.euler, expected.euler) << symmetry;
    }
  }
}

Dense negated(Dense volume) {
  for (float& sample : volume.samples) sample = -sample;
  return volume;
}

/// The vertices on grid edges, sorted. (Where a tunnel is cut into two fans, and so where their centres lie, may depend
/// on the colours.)
std::vector<std::array<float, 3>> points_on_edges(const Mesh& mesh) {
  std::vector<std::array<float, 3>> points;
  for (const Eigen::Vector3f& p : mesh.positions_m) {
    if ((p.array() == p.array().round()).count() >= 2) points.push_back({p.x(), p.y(), p.z()});
  }
  std::sort(points.begin(), points.end());
  return points;
}

/// The directed edges that bound the mesh, by position, sorted.
std::vector<std::array<float, 6>> boundary_of(const Mesh& mesh, bool reversed) {
  std::set<std::array<std::uint32_t, 2>> sides;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) sides.insert({t[i], t[(i + 1) % 3]});
  }
  std::vector<std::array<float, 6>> boundary;
  for (const auto& [a, b] : sides) {
    if (sides.count({b, a}) > 0) continue;
    const Eigen::Vector3f& from = mesh.positions_m[reversed ? b : a];
    const Eigen::Vector3f& to = mesh.positions_m[reversed ? a : b];
    boundary.push_back({from.x(), from.y(), from.z(), to.x(), to.y(), to.z()});
  }
  std::sort(boundary.begin(), boundary.end());
  return boundary;
}

void expect_turned_round(const Mesh& turned, const Mesh& mesh) {
  EXPECT_EQ(points_on_edges(turned), points_on_edges(mesh));
  EXPECT_EQ(boundary_of(turned, true), boundary_of(mesh, false));
  const MeshCheck expected = check_mesh(mesh);
  const MeshCheck check = check_mesh(turned);
  EXPECT_EQ(check.vertices, expected.vertices);
  EXPECT_EQ(check.triangles, expected.triangles);
  EXPECT_EQ(check.components, expected.components);
  EXPECT_EQ(check.euler, expected.euler);
  test::expect_manifold(check);
}

TEST(Negation, TurnsTheSurfaceRoundAndChangesNothingElse) {  // white noise has no ties
  const Dense volume = test::white_noise(20, 3);
  for (const Decider decider : {Decider::kTrilinear, Decider::kAsymptotic, Decider::kChord}) {
    SCOPED_TRACE(name_of(decider));
    ExtractConfig config;
    config.decider = decider;
    config.isovalue = 0.125;
    const Mesh mesh = test::extract(volume, config).mesh;
    config.isovalue = -0.125;
    expect_turned_round(test::extract(negated(volume), config).mesh, mesh);
  }
}

TEST(Negation, SwapsFixedHighAndFixedLow) {
  ExtractConfig high;
  high.decider = Decider::kFixedHigh;
  ExtractConfig low;
  low.decider = Decider::kFixedLow;
  const Dense volume = test::white_noise(20, 4);
  expect_turned_round(test::extract(negated(volume), low).mesh, test::extract(volume, high).mesh);
}

TEST_P(Equivariance, NegationTurnsAClosedSurfaceInsideOut) {
  Dense volume = test::white_noise(20, 3);
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      for (const int end : {0, 19}) volume.at(end, i, j) = volume.at(i, end, j) = volume.at(i, j, end) = -1;
    }
  }
  const Mesh mesh = test::extract(volume, config()).mesh;
  const Mesh turned = test::extract(negated(volume), config()).mesh;
  ASSERT_TRUE(check_mesh(mesh).is_closed());
  ASSERT_TRUE(check_mesh(turned).is_closed());
  EXPECT_GT(signed_volume_m3(mesh), 0);
  EXPECT_LT(signed_volume_m3(turned), 0);
}

}  // namespace
}  // namespace scanknit
