// The decompositions of a cell into tetrahedra, and the promises of marching them.
#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "core/mesh/mesh_area.h"
#include "extract/reference/marching_tetrahedra.h"
#include "tests/extract/volumes.h"

namespace scanknit {
namespace {

using test::Dense;

/// A Dense as blocks, its first sample at index `first`.
class DenseBlocks final : public BlockSource {
 public:
  explicit DenseBlocks(const Dense& volume, const Eigen::Vector3i& first = {-11, -5, 3},
                       const Eigen::Affine3d& T_world_index = Eigen::Affine3d::Identity())
      : volume_(volume), first_(first), T_world_index_(T_world_index) {
    const auto begin = [&](int axis) { return first[axis] & -kBlockCells; };
    for (int x = begin(0); x < first.x() + volume.n; x += kBlockCells) {
      for (int y = begin(1); y < first.y() + volume.n; y += kBlockCells) {
        for (int z = begin(2); z < first.z() + volume.n; z += kBlockCells) origins_.emplace_back(x, y, z);
      }
    }
  }

  [[nodiscard]] std::span<const Eigen::Vector3i> origins() const override { return origins_; }
  void classify(std::size_t, float, std::span<BlockSigns>) const override { FAIL() << "the reference looks at values"; }
  void load_values(std::size_t block, ValueBlock& values) const override {
    values.show_buffer();
    for (int x = kBlockFirst; x <= kBlockLast; ++x) {
      for (int y = kBlockFirst; y <= kBlockLast; ++y) {
        for (int z = kBlockFirst; z <= kBlockLast; ++z) {
          const Eigen::Vector3i p = origins_[block] + Eigen::Vector3i(x, y, z) - first_;
          const bool is_inside = p.minCoeff() >= 0 && p.maxCoeff() < volume_.n;
          values.row(x, y)[static_cast<std::size_t>(z - kBlockFirst)] =
              is_inside ? volume_.at(p.x(), p.y(), p.z()) : kUnobserved;
        }
      }
    }
  }
  [[nodiscard]] const Eigen::Affine3d& T_world_index() const override { return T_world_index_; }

 private:
  const Dense& volume_;
  Eigen::Vector3i first_;
  Eigen::Affine3d T_world_index_;
  std::vector<Eigen::Vector3i> origins_;
};

struct March {
  double isovalue = 0;
  VertexPlacement placement = VertexPlacement::kLinear;
  bool inside_is_high = false;
  bool normals = false;

  [[nodiscard]] Mesh operator()(const BlockSource& source, TetraSplit split) const {
    return march_tetrahedra(source, split, isovalue, placement, inside_is_high, normals).value();
  }
};

/// How many triangles of a cell's face, as the decomposition cuts it, have corners of both colours: said here without
/// the tables. `ring`: the face's corners in cyclic order from the least; `diagonal_from_0`: k5 and k6 cut from 0 to 2.
std::size_t crossed_triangles(const std::array<double, 4>& ring, TetraSplit split, bool diagonal_from_0,
                              double isovalue) {
  const auto crossed = [&](double a, double b, double c) {
    const int highs = (a >= isovalue ? 1 : 0) + (b >= isovalue ? 1 : 0) + (c >= isovalue ? 1 : 0);
    return highs == 1 || highs == 2 ? std::size_t{1} : std::size_t{0};
  };
  const auto& [a, b, c, d] = ring;
  if (split == TetraSplit::k24) {
    const double middle = (a + b + c + d) / 4;
    return crossed(a, b, middle) + crossed(b, c, middle) + crossed(c, d, middle) + crossed(d, a, middle);
  }
  return diagonal_from_0 ? crossed(a, b, c) + crossed(c, d, a) : crossed(b, c, d) + crossed(d, a, b);
}

/// The boundary: where the surface meets a grid face that has a whole (observed) cell on one side only.
std::size_t expected_boundary_edges(const Dense& volume, const Eigen::Vector3i& first, TetraSplit split,
                                    double isovalue) {
  const auto is_whole = [&](const Eigen::Vector3i& cell) {
    if (cell.minCoeff() < 0 || cell.maxCoeff() > volume.n - 2) return false;
    for (int i = 0; i < 8; ++i) {
      if (!std::isfinite(volume.at(cell.x() + (i & 1), cell.y() + ((i >> 1) & 1), cell.z() + (i >> 2)))) return false;
    }
    return true;
  };
  const auto value = [&](const Eigen::Vector3i& p) { return static_cast<double>(volume.at(p.x(), p.y(), p.z())); };
  std::size_t edges = 0;
  for (int i = 0; i < volume.n * volume.n * volume.n; ++i) {
    const Eigen::Vector3i p(i / (volume.n * volume.n), i / volume.n % volume.n, i % volume.n);
    for (int axis = 0; axis < 3; ++axis) {
      if (is_whole(p) == is_whole(p - Eigen::Vector3i::Unit(axis))) continue;
      const Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
      const Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
      const bool is_even = (p + first).sum() % 2 == 0;  // k5 cuts between points of even sum
      edges += crossed_triangles({value(p), value(p + u), value(p + u + v), value(p + v)}, split,
                                 split == TetraSplit::k6 || is_even, isovalue);
    }
  }
  return edges;
}

Dense sphere(int n, double radius, const Eigen::Vector3d& centre) {
  return test::dense_from(
      n, [&](double x, double y, double z) { return (Eigen::Vector3d(x, y, z) - centre).norm() - radius; });
}

constexpr std::array kSplits{TetraSplit::k5, TetraSplit::k6, TetraSplit::k24};
std::string name_of(TetraSplit split) {
  return split == TetraSplit::k5 ? "k5" : split == TetraSplit::k6 ? "k6" : "k24";
}

/// The triangles that tetrahedra have in common with a face of the cell, each as the set of its points in half cells
/// along the face's axes.
std::set<std::set<std::pair<int, int>>> triangles_in_face(std::span<const Tetra> tetrahedra, int axis, int side) {
  std::set<std::set<std::pair<int, int>>> triangles;
  for (const Tetra& tetra : tetrahedra) {
    std::set<std::pair<int, int>> points;
    for (const CellPoint point : tetra) {
      if (half_coordinate(point, axis) == 2 * side)
        points.emplace(half_coordinate(point, (axis + 1) % 3), half_coordinate(point, (axis + 2) % 3));
    }
    if (points.size() == 3) triangles.insert(points);
  }
  return triangles;
}

TEST(Tetrahedra, OfNeighbouringCellsMeetInTheSameTriangles) {
  for (const TetraSplit split : kSplits) {
    for (const std::size_t parity : {0u, 1u}) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto behind = triangles_in_face(tetrahedra(split, parity), axis, 1);
        EXPECT_EQ(behind.size(), split == TetraSplit::k24 ? 4u : 2u);
        EXPECT_EQ(behind, triangles_in_face(tetrahedra(split, 1 - parity), axis, 0)) << name_of(split);
      }
    }
  }
}

TEST(Tetrahedra, PolygonsCrossEachEdgeBetweenHighAndLowOnce) {
  for (unsigned highs = 0; highs < 16; ++highs) {
    std::set<std::pair<int, int>> crossed;
    for (int high = 0; high < 4; ++high) {
      for (int low = 0; low < 4; ++low) {
        if (((highs >> high) & 1) != 0 && ((highs >> low) & 1) == 0) crossed.emplace(high, low);
      }
    }
    std::set<std::pair<int, int>> edges;
    for (std::size_t i = 0; i < kTetraPolygons[highs].size; ++i)
      edges.emplace(kTetraPolygons[highs].edges[i][0], kTetraPolygons[highs].edges[i][1]);
    EXPECT_EQ(edges, crossed) << highs;
    EXPECT_EQ(kTetraPolygons[highs].size, crossed.size()) << highs;
  }
}

class MarchingTetrahedra : public ::testing::TestWithParam<TetraSplit> {
 protected:
  /// On a turned, stretched and mirrored grid.
  void expect_sound(const Dense& volume, const March& march = {}) const {
    const Eigen::Vector3i first(-11, -5, 3);
    Eigen::Affine3d T_world_index = Eigen::Affine3d::Identity();
    T_world_index.translate(Eigen::Vector3d(0.3, -1.7, 2.5));
    T_world_index.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
    T_world_index.scale(Eigen::Vector3d(0.004, -0.005, 0.012));
    const Mesh mesh = march(DenseBlocks(volume, first, T_world_index), GetParam());
    const MeshCheck check = check_mesh(mesh);
    EXPECT_GT(check.triangles, 0u);
    test::expect_manifold(check);
    EXPECT_EQ(check.degenerate_triangles, 0u);
    EXPECT_EQ(check.boundary_edges, expected_boundary_edges(volume, first, GetParam(), march.isovalue));
  }
};
INSTANTIATE_TEST_SUITE_P(Splits, MarchingTetrahedra, ::testing::ValuesIn(kSplits),
                         [](const auto& suite) { return name_of(suite.param); });

constexpr std::array kSeeds{1u, 2u, 3u, 4u};

TEST_P(MarchingTetrahedra, WhiteNoiseIsManifold) {
  for (const unsigned seed : kSeeds) expect_sound(test::white_noise(20, seed));
}

TEST_P(MarchingTetrahedra, NoiseOfThreeLevelsWithTiesIsManifold) {
  for (const unsigned seed : kSeeds) {
    for (const double isovalue : {0.0, 1.0}) expect_sound(test::three_level_noise(20, seed), {.isovalue = isovalue});
  }
}

TEST_P(MarchingTetrahedra, MidEdgeMeshIsManifold) {
  for (const unsigned seed : kSeeds)
    expect_sound(test::three_level_noise(20, seed), {.placement = VertexPlacement::kMidEdge});
}

TEST_P(MarchingTetrahedra, HolesThatPinchLeaveTheMeshManifold) {
  for (const unsigned one_in : {50u, 6u, 3u}) {
    for (const unsigned seed : kSeeds) {
      Dense volume = test::white_noise(20, seed);
      test::punch_holes(volume, one_in, seed + 100);
      expect_sound(volume);
      volume = test::three_level_noise(20, seed);
      test::punch_holes(volume, one_in, seed + 200);
      expect_sound(volume);
    }
  }
}

TEST_P(MarchingTetrahedra, TwoCellsAcrossAGridEdgeArePinchedAndSplit) {
  Dense volume(3, test::kNaN);
  for (int i = 0; i < 2; ++i) {
    for (int corner = 0; corner < 8; ++corner)
      volume.at(i + (corner & 1), i + ((corner >> 1) & 1), corner >> 2) = corner < 4 ? -1.0f : 1.0f;
  }
  const MeshCheck check = check_mesh(March{}(DenseBlocks(volume), GetParam()));
  EXPECT_EQ(check.components, 2u);
  EXPECT_EQ(check.euler, 2);
  EXPECT_EQ(check.non_manifold_vertices, 0u);
}

TEST_P(MarchingTetrahedra, FarFromTheOriginNoTriangleDegenerates) {
  const Dense volume = test::three_level_noise(16, 2);
  Eigen::Affine3d T_world_index = Eigen::Affine3d::Identity();
  T_world_index.translate(Eigen::Vector3d(5, 0, -80)).scale(0.001);
  const Mesh mesh = March{}(DenseBlocks(volume, {100000, -200000, 8000}, T_world_index), GetParam());
  EXPECT_EQ(check_mesh(mesh).degenerate_triangles, 0u);
}

constexpr double kRadius = 9.3;                     // voxels
constexpr double kSagitta = 3.0 / (8.0 * kRadius);  // of a chord as long as a cell's diagonal

TEST_P(MarchingTetrahedra, SphereIsClosedWithItsVolumeAndNormals) {
  const Eigen::Vector3d centre(12.1, 11.8, 12.3);
  const Dense volume = sphere(25, kRadius, centre);
  const Mesh mesh = March{.normals = true}(DenseBlocks(volume, {0, 0, 0}), GetParam());
  const MeshCheck check = check_mesh(mesh);
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.euler, 2);
  constexpr double kShrinkage = 3 * kSagitta / kRadius;
  const double expected = 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius, 3);
  EXPECT_NEAR(signed_volume_m3(mesh), expected, kShrinkage * expected);

  ASSERT_EQ(mesh.normals.size(), mesh.positions_m.size());
  constexpr double kCosineOfTiltedTriangles = 0.99;
  constexpr double kUnitTolerance = 1e-5;  // rounding of three floats
  for (std::size_t v = 0; v < mesh.normals.size(); ++v) {
    const Eigen::Vector3d normal = mesh.normals[v].cast<double>();
    ASSERT_NEAR(normal.norm(), 1, kUnitTolerance);
    ASSERT_GT(normal.dot((mesh.positions_m[v].cast<double>() - centre).normalized()), kCosineOfTiltedTriangles);
  }
}

TEST_P(MarchingTetrahedra, NormalsAreLeftOutUnlessAskedFor) {
  const Dense volume = sphere(9, 2.5, {4, 4, 4});
  EXPECT_TRUE(March{}(DenseBlocks(volume), GetParam()).normals.empty());
}

TEST_P(MarchingTetrahedra, MidEdgeSphereIsClosedAndOutwards) {
  const Dense volume = sphere(25, kRadius, {12, 12, 12});
  const Mesh mesh = March{.placement = VertexPlacement::kMidEdge}(DenseBlocks(volume), GetParam());
  EXPECT_TRUE(check_mesh(mesh).is_closed());
  EXPECT_EQ(check_mesh(mesh).euler, 2);
  EXPECT_GT(signed_volume_m3(mesh), 0);
  for (const Eigen::Vector3f& p : mesh.positions_m) ASSERT_EQ(4 * p, (4 * p).array().round().matrix());
}

TEST_P(MarchingTetrahedra, InsideMayBeHigh) {
  Dense volume = sphere(13, 4.2, {6, 6, 6});
  for (float& sample : volume.samples) sample = -sample;
  EXPECT_GT(signed_volume_m3(March{.inside_is_high = true}(DenseBlocks(volume), GetParam())), 0);
  EXPECT_LT(signed_volume_m3(March{.inside_is_high = false}(DenseBlocks(volume), GetParam())), 0);
}

TEST_P(MarchingTetrahedra, AnyAffineMapScalesTheVolumeByItsDeterminantWithoutSign) {
  const Dense volume = sphere(13, 4.2, {6, 6, 6});
  const double expected = signed_volume_m3(March{}(DenseBlocks(volume), GetParam()));
  for (const Eigen::Vector3d& scale : {Eigen::Vector3d(1, 2, 3), {-1, 2, 3}, {-1, -1, 2}, {-0.5, -1, -2}}) {
    Eigen::Affine3d T_world_index = Eigen::Affine3d::Identity();
    T_world_index.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(3, 1, 2).normalized())).scale(scale);
    const Mesh mesh = March{}(DenseBlocks(volume, {-11, -5, 3}, T_world_index), GetParam());
    constexpr double kRoundingOfFloats = 1e-5;
    const double factor = std::abs(scale.prod());
    EXPECT_NEAR(signed_volume_m3(mesh), factor * expected, kRoundingOfFloats * factor * expected);
  }
}

TEST_P(MarchingTetrahedra, SampleOnTheIsovalueIsHigh) {
  Dense volume(5, -1);
  volume.at(2, 2, 2) = 0;
  const MeshCheck check = check_mesh(March{.inside_is_high = true}(DenseBlocks(volume), GetParam()));
  EXPECT_TRUE(check.is_closed());
  EXPECT_EQ(check.euler, 2);
  EXPECT_EQ(check.degenerate_triangles, 0u);
}

TEST_P(MarchingTetrahedra, ConstantVolumeHasNoSurface) {
  for (const double isovalue : {0.1, static_cast<double>(0.1f), 0.1001})
    EXPECT_TRUE(March{.isovalue = isovalue}(DenseBlocks(Dense(6, 0.1f)), GetParam()).empty());
}

TEST_P(MarchingTetrahedra, ExtremeSamplesGiveFiniteVertices) {
  Dense volume = test::white_noise(8, 3);
  for (float& sample : volume.samples) sample = sample < 0 ? std::numeric_limits<float>::lowest() : 1e-45f;
  EXPECT_TRUE(check_mesh(March{}(DenseBlocks(volume), GetParam())).is_well_formed);
}

TEST_P(MarchingTetrahedra, WhereBlocksBeginDoesNotMatter) {
  const Dense volume = test::white_noise(14, 7);
  const MeshCheck expected = check_mesh(March{}(DenseBlocks(volume, {0, 0, 0}), GetParam()));
  for (const Eigen::Vector3i& first : {Eigen::Vector3i(2, 0, 0), {3, -5, 4}, {-7, -9, -6}}) {  // even, for k5
    const MeshCheck check = check_mesh(March{}(DenseBlocks(volume, first), GetParam()));
    EXPECT_EQ(check.vertices, expected.vertices);
    EXPECT_EQ(check.triangles, expected.triangles);
    EXPECT_EQ(check.boundary_edges, expected.boundary_edges);
    EXPECT_EQ(check.euler, expected.euler);
  }
}

TEST(MarchingTetrahedraSphere, HasTheSameAreaForEachSplit) {
  constexpr double kShrinkage = 2 * kSagitta / kRadius;
  const Dense volume = sphere(25, kRadius, {12.1, 11.8, 12.3});
  const double expected = 4 * std::numbers::pi * kRadius * kRadius;
  for (const TetraSplit split : kSplits)
    EXPECT_NEAR(area_m2(March{}(DenseBlocks(volume), split)), expected, kShrinkage * expected) << name_of(split);
}

/// The volume after one of the 48 symmetries of the cube.
Dense moved_by(int symmetry, const Dense& volume) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  Dense moved(volume.n);
  for (int i = 0; i < volume.n * volume.n * volume.n; ++i) {
    const int from[3] = {i / (volume.n * volume.n), i / volume.n % volume.n, i % volume.n};
    int to[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int c = from[kOrders[symmetry / 8][axis]];
      to[axis] = ((symmetry >> axis) & 1) != 0 ? volume.n - 1 - c : c;
    }
    moved.at(to[0], to[1], to[2]) = volume.at(from[0], from[1], from[2]);
  }
  return moved;
}

// k5 and k6 prefer diagonals, which a symmetry moves: they make no such promise.
TEST(MarchingTetrahedra24, SymmetriesOfTheCubeKeepTheInvariants) {
  for (const Dense& volume : {test::white_noise(12, 9), test::three_level_noise(12, 9)}) {
    const MeshCheck expected = check_mesh(March{}(DenseBlocks(volume), TetraSplit::k24));
    for (int symmetry = 0; symmetry < 48; ++symmetry) {
      const Dense moved = moved_by(symmetry, volume);
      const MeshCheck check = check_mesh(March{}(DenseBlocks(moved), TetraSplit::k24));
      ASSERT_EQ(check.vertices, expected.vertices) << symmetry;
      ASSERT_EQ(check.triangles, expected.triangles) << symmetry;
      ASSERT_EQ(check.components, expected.components) << symmetry;
      ASSERT_EQ(check.boundary_edges, expected.boundary_edges) << symmetry;
      ASSERT_EQ(check.euler, expected.euler) << symmetry;
    }
  }
}

}  // namespace
}  // namespace scanknit
