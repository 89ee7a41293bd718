// A mesh in pieces is the same mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "core/mesh/split_mesh.h"

namespace scanknit {
namespace {

constexpr int kSide = 40;

/// A square of kSide^2 vertices, each of its own colour.
Mesh square() {
  Mesh mesh;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      mesh.positions_m.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
      mesh.colours.push_back({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 0});
    }
  }
  for (int y = 0; y + 1 < kSide; ++y) {
    for (int x = 0; x + 1 < kSide; ++x) {
      const auto a = static_cast<std::uint32_t>(y * kSide + x);
      mesh.triangles.emplace_back(a, a + 1, a + kSide);
      mesh.triangles.emplace_back(a + 1, a + kSide + 1, a + kSide);
    }
  }
  return mesh;
}

using Corners = std::array<float, 6>;

std::vector<Corners> corners_of(const std::vector<Mesh>& meshes) {
  std::vector<Corners> all;
  for (const Mesh& mesh : meshes) {
    for (const auto& [a, b, c] : mesh.triangles) {
      const auto& p = mesh.positions_m;
      all.push_back({p[a].x(), p[a].y(), p[b].x(), p[b].y(), p[c].x(), p[c].y()});
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(SplitMesh, PiecesAreTheWhole) {
  const Mesh mesh = square();
  const auto pieces = split_mesh(mesh, 100);
  EXPECT_EQ(corners_of(pieces), corners_of({mesh}));
  for (const Mesh& piece : pieces) {
    EXPECT_LE(piece.triangles.size(), 100u);
    EXPECT_TRUE(check_mesh(piece).is_well_formed);
    for (std::size_t i = 0; i < piece.positions_m.size(); ++i) {
      EXPECT_EQ(static_cast<float>(piece.colours[i].r), piece.positions_m[i].x());
      EXPECT_EQ(static_cast<float>(piece.colours[i].g), piece.positions_m[i].y());
    }
  }
}

TEST(SplitMesh, ASmallMeshIsOnePiece) {
  EXPECT_EQ(split_mesh(square(), 1'000'000).size(), 1u);
}

TEST(SplitMesh, NothingIsNoPiece) {
  EXPECT_TRUE(split_mesh(Mesh(), 10).empty());
}

TEST(SplitMesh, TrianglesAtOnePlaceAreStillSplit) {
  Mesh mesh;
  mesh.positions_m.assign(3, {0, 0, 0});
  mesh.triangles.assign(50, {0, 1, 2});
  EXPECT_EQ(split_mesh(mesh, 1).size(), 50u);
}

TEST(SplitMesh, PartsNameTheMeshsVertices) {
  const Mesh mesh = square();
  MeshSplit split(mesh, {.vertices = 100});
  ASSERT_GT(split.parts(), 1u);
  std::vector<Triangle> all;
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < split.parts(); ++i) {
    const MeshPart part = split.part(i);
    EXPECT_LE(part.vertices.size(), 100u);
    vertices += part.vertices.size();
    for (const auto& [a, b, c] : part.triangles) {
      all.emplace_back(part.vertices.at(a), part.vertices.at(b), part.vertices.at(c));
    }
  }
  EXPECT_EQ(split.vertices(), vertices);
  std::vector<Triangle> expected = mesh.triangles;
  std::sort(all.begin(), all.end());
  std::sort(expected.begin(), expected.end());
  EXPECT_TRUE(all == expected);
}

TEST(SplitMesh, APartIsCompact) {
  const Mesh mesh = square();
  MeshSplit split(mesh, {.vertices = 100});
  for (std::size_t i = 0; i < split.parts(); ++i) {
    Eigen::AlignedBox3f box;
    for (const std::uint32_t vertex : split.part(i).vertices) box.extend(mesh.positions_m[vertex]);
    EXPECT_LE(box.sizes().maxCoeff(), kSide / 2);
  }
}

TEST(SplitMesh, ATriangleIsNotCut) {
  EXPECT_EQ(MeshSplit(square(), {.vertices = 2}).parts(), square().triangles.size());
}

}  // namespace
}  // namespace scanknit
