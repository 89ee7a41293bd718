// The numbering of a cell, its symmetries and the tables made from them.
#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <set>
#include <utility>

#include "extract/cell/triangulate_cell.h"

namespace scanknit {
namespace {

using DirectedEdge = std::pair<int, int>;

/// Calls check(highs, joined) for every case and every resolution of its ambiguous faces.
template <typename Check>
void for_each_resolution(const Check& check) {
  for (unsigned highs = 0; highs < 256; ++highs) {
    for (unsigned joined = 0; joined < 64; ++joined) {
      if ((joined & ~unsigned{kAmbiguousFaces[highs]}) == 0)
        check(static_cast<CornerMask>(highs), static_cast<FaceMask>(joined));
    }
  }
}

std::multiset<DirectedEdge> directed_edges(const CellTriangles& triangles) {
  std::multiset<DirectedEdge> edges;
  for (const CellTriangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.insert({t[i], t[(i + 1) % 3]});
  }
  return edges;
}

TEST(Cell, EdgeBetweenItsEndsIsTheEdge) {
  for (int edge = 0; edge < kEdges; ++edge)
    EXPECT_EQ(edge_between(edge_low_corner(edge), edge_high_corner(edge)), edge) << edge;
}

TEST(Cell, EdgesAreNumberedByAxisThenPosition) {
  EXPECT_EQ(edge_low_corner(2), 4);   // x-edge at y = 0, z = 1
  EXPECT_EQ(edge_low_corner(7), 5);   // y-edge at x = 1, z = 1
  EXPECT_EQ(edge_low_corner(10), 2);  // z-edge at x = 0, y = 1
}

TEST(Cell, FaceCornersTurnCounterClockwiseSeenFromOutside) {
  for (std::size_t face = 0; face < kFaces; ++face) {
    const auto& c = kFaceCorners[face];
    std::array<int, 3> a{};
    std::array<int, 3> b{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      a[i] = corner_coordinate(c[1], axis) - corner_coordinate(c[0], axis);
      b[i] = corner_coordinate(c[2], axis) - corner_coordinate(c[1], axis);
    }
    const std::size_t axis = face / 2;
    const int normal = a[(axis + 1) % 3] * b[(axis + 2) % 3] - a[(axis + 2) % 3] * b[(axis + 1) % 3];
    EXPECT_EQ(normal, face % 2 == 1 ? 1 : -1) << face;
  }
}

TEST(Cell, EveryEdgeLiesInTwoFacesAndEveryFaceHoldsFourEdges) {
  std::array<int, kFaces> edges_of{};
  for (const FaceMask faces : kEdgeFaces) {
    EXPECT_EQ(std::popcount(faces), 2);
    for (std::size_t f = 0; f < kFaces; ++f) edges_of[f] += (faces >> f) & 1;
  }
  for (const int count : edges_of) EXPECT_EQ(count, 4);
}

TEST(CubeSymmetry, RotationsAre24DifferentOnes) {
  std::set<std::array<std::uint8_t, kCorners>> seen;
  for (const CubeSymmetry& rotation : kRotations) seen.insert(rotation.corner);
  EXPECT_EQ(seen.size(), 24u);
}

TEST(CubeSymmetry, ReflectionIsNoRotation) {
  for (const CubeSymmetry& rotation : kRotations) EXPECT_NE(rotation.corner, kMirrorX.corner);
}

TEST(CubeSymmetry, EdgesMoveWithTheirEnds) {
  for (const CubeSymmetry& rotation : kRotations) {
    for (int e = 0; e < kEdges; ++e) {
      const auto low = rotation.corner[static_cast<std::size_t>(edge_low_corner(e))];
      const auto high = rotation.corner[static_cast<std::size_t>(edge_high_corner(e))];
      EXPECT_EQ(edge_between(low, high), rotation.edge[static_cast<std::size_t>(e)]);
    }
  }
}

TEST(PackedTriangles, GiveBackWhatWasPacked) {
  const PackedTriangles packed{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}, {11, 0, 5}};
  ASSERT_EQ(packed.size(), PackedTriangles::kMaxTriangles);
  EXPECT_EQ(packed[0], (CellTriangle{0, 1, 2}));
  EXPECT_EQ(packed[3], (CellTriangle{9, 10, 11}));
  EXPECT_EQ(packed[4], (CellTriangle{11, 0, 5}));
}

TEST(PackedTriangles, FitOneWord) {
  EXPECT_EQ(sizeof(PackedTriangles), 8u);
}

TEST(CaseTable, ConfigurationsHaveTheirKnownSizes) {
  std::map<int, int> size;
  for (const auto configuration : kCaseTable.configuration) ++size[configuration];
  const std::map<int, int> known{{0, 2}, {1, 16}, {2, 24}, {3, 24},  {4, 8},   {5, 48}, {6, 48}, {7, 16},
                                 {8, 6}, {9, 8},  {10, 6}, {11, 12}, {12, 24}, {13, 2}, {14, 12}};
  EXPECT_EQ(size, known);
}

TEST(CaseTable, AmbiguousFacesFollowFromTheConfiguration) {
  constexpr std::array<int, 15> kKnown{0, 0, 0, 1, 0, 0, 1, 3, 0, 0, 2, 0, 2, 6, 0};
  for (std::size_t highs = 0; highs < 256; ++highs)
    EXPECT_EQ(std::popcount(kAmbiguousFaces[highs]), kKnown[kCaseTable.configuration[highs]]) << highs;
}

TEST(CaseTable, ConfigurationIsTheSameForRotatedAndFlippedCases) {
  for (unsigned highs = 0; highs < 256; ++highs) {
    const auto mask = static_cast<CornerMask>(highs);
    EXPECT_EQ(kCaseTable.configuration[colour_flipped(mask)], kCaseTable.configuration[mask]);
    for (const CubeSymmetry& rotation : kRotations)
      EXPECT_EQ(kCaseTable.configuration[transformed(mask, rotation)], kCaseTable.configuration[mask]);
  }
}

TEST(TriangulateCell, BoundaryIsExactlyTheTracedContours) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    const auto edges = directed_edges(triangulate_cell(highs, joined));
    std::set<DirectedEdge> boundary;
    for (const DirectedEdge& e : edges) {
      if (edges.count({e.second, e.first}) == 0) boundary.insert(e);
    }
    const auto successor = contour_successors(highs, joined);
    std::set<DirectedEdge> contours;
    for (int edge = 0; edge < kEdges; ++edge) {
      if (is_crossed(highs, edge)) contours.insert({edge, successor[static_cast<std::size_t>(edge)]});
    }
    EXPECT_EQ(boundary, contours) << int{highs} << " joined " << int{joined};
  });
}

TEST(TriangulateCell, EveryDirectedEdgeIsUsedOnce) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    const auto edges = directed_edges(triangulate_cell(highs, joined));
    for (const DirectedEdge& e : edges) EXPECT_EQ(edges.count(e), 1u) << int{highs} << " joined " << int{joined};
  });
}

TEST(TriangulateCell, NoChordLiesInAFace) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    const auto edges = directed_edges(triangulate_cell(highs, joined));
    for (const auto& [a, b] : edges) {
      const bool is_chord = edges.count({b, a}) > 0 && a < kEdges && b < kEdges;
      if (is_chord) {
        EXPECT_TRUE(is_chord_inside_cell(static_cast<EdgeIndex>(a), static_cast<EdgeIndex>(b)))
            << int{highs} << " joined " << int{joined};
      }
    }
  });
}

TEST(TriangulateCell, EachContourBecomesOneDisc) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    const CellTriangles triangles = triangulate_cell(highs, joined);
    const Contours contours = trace_contours(highs, joined);
    std::size_t crossed = 0;
    for (int edge = 0; edge < kEdges; ++edge) crossed += is_crossed(highs, edge) ? 1 : 0;
    const std::size_t interior = triangles.interior_vertices().size();
    // A disc of n boundary and m interior vertices has n - 2 + 2 m triangles.
    EXPECT_EQ(triangles.size(), crossed - 2 * contours.count + 2 * interior);
  });
}

TEST(TriangulateCell, OnlyCellsWithSeveralAmbiguousFacesNeedAnInteriorVertex) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    if (!triangulate_cell(highs, joined).interior_vertices().empty()) {
      EXPECT_GE(std::popcount(kAmbiguousFaces[highs]), 2);
    }
  });
}

TEST(TriangulateCell, RotatedCellsHaveAsManyTriangles) {
  for_each_resolution([](CornerMask highs, FaceMask joined) {
    for (const CubeSymmetry& symmetry : {kRotateX, kRotateDiagonal, kMirrorX}) {
      unsigned moved_faces = 0;
      for (unsigned face = 0; face < kFaces; ++face) {
        if (((joined >> face) & 1) == 0) continue;
        const auto& c = kFaceCorners[face];
        const unsigned all = (1u << symmetry.corner[static_cast<std::size_t>(c[0])]) |
                             (1u << symmetry.corner[static_cast<std::size_t>(c[2])]);
        for (unsigned to = 0; to < kFaces; ++to) {
          const auto& d = kFaceCorners[to];
          if (all == ((1u << d[0]) | (1u << d[2])) || all == ((1u << d[1]) | (1u << d[3]))) moved_faces |= 1u << to;
        }
      }
      const CellTriangles moved = triangulate_cell(transformed(highs, symmetry), static_cast<FaceMask>(moved_faces));
      EXPECT_EQ(moved.size(), triangulate_cell(highs, joined).size());
    }
  });
}

}  // namespace
}  // namespace scanknit
