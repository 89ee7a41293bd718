// Every row of the CellTable is a sound piece of surface. There are few enough to look at all of them.
#include "extract/cell/cell_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace scanknit {
namespace {

using DirectedEdge = std::pair<EdgeIndex, EdgeIndex>;

const CellTable& table() {
  return CellTable::get();
}

/// Calls check(entry) for every row, and says which one failed.
template <typename Check>
void for_each_row(const Check& check) {
  for (std::size_t row = 0; row < table().size(); ++row) {
    const auto entry = static_cast<CellEntry>(row);
    const int highs = table().highs(entry);
    const int joined = table().joined_faces(entry);
    SCOPED_TRACE(::testing::Message() << "highs " << highs << " joined " << joined << " row " << row);
    check(entry);
    if (::testing::Test::HasFailure()) return;
  }
}

std::multiset<DirectedEdge> directed_edges(CellEntry entry) {
  std::multiset<DirectedEdge> edges;
  for (const CellTriangle& t : table().triangles(entry)) {
    for (std::size_t i = 0; i < 3; ++i) edges.insert({t[i], t[(i + 1) % 3]});
  }
  return edges;
}

std::set<DirectedEdge> contour_segments(const Contours& contours) {
  std::set<DirectedEdge> segments;
  for (std::size_t i = 0; i < contours.count; ++i) {
    const auto polygon = contours[i];
    for (std::size_t k = 0; k < polygon.size(); ++k) segments.insert({polygon[k], polygon[(k + 1) % polygon.size()]});
  }
  return segments;
}

Contours contours_of(CellEntry entry) {
  return trace_contours(table().highs(entry), table().joined_faces(entry));
}

std::set<EdgeIndex> vertices_of(CellEntry entry) {
  std::set<EdgeIndex> vertices;
  for (const CellTriangle& t : table().triangles(entry)) vertices.insert(t.begin(), t.end());
  return vertices;
}

/// The sets of vertices that triangles connect.
std::set<std::set<EdgeIndex>> components_of(CellEntry entry) {
  std::set<std::set<EdgeIndex>> components;
  for (const CellTriangle& t : table().triangles(entry)) {
    std::set<EdgeIndex> joined(t.begin(), t.end());
    for (auto it = components.begin(); it != components.end();) {
      const bool meets = std::any_of(t.begin(), t.end(), [&](EdgeIndex v) { return it->count(v) > 0; });
      if (meets) joined.insert(it->begin(), it->end());
      it = meets ? components.erase(it) : std::next(it);
    }
    components.insert(joined);
  }
  return components;
}

TEST(CellTable, HasARowForEveryResolutionOfEveryCase) {
  std::set<std::pair<int, int>> seen;
  for_each_row([&](CellEntry entry) {
    if (!table().has_tunnel(entry)) seen.insert({table().highs(entry), table().joined_faces(entry)});
  });
  std::size_t resolutions = 0;
  for (const FaceMask faces : kAmbiguousFaces) resolutions += std::size_t{1} << std::popcount(faces);
  EXPECT_EQ(seen.size(), resolutions);
}

TEST(CellTable, EntryIsTheRowOfItsCase) {
  for_each_row([](CellEntry entry) {
    const CellEntry plain = table().entry(table().highs(entry), table().joined_faces(entry));
    EXPECT_EQ(table().highs(plain), table().highs(entry));
    EXPECT_EQ(table().joined_faces(plain), table().joined_faces(entry));
    EXPECT_FALSE(table().has_tunnel(plain));
    EXPECT_EQ(plain == entry, !table().has_tunnel(entry));
  });
}

TEST(CellTable, JoinsOnlyAmbiguousFaces) {
  for_each_row(
      [](CellEntry entry) { EXPECT_EQ(table().joined_faces(entry) & ~kAmbiguousFaces[table().highs(entry)], 0); });
}

TEST(CellTable, NoDirectedEdgeIsUsedTwice) {
  for_each_row([](CellEntry entry) {
    const auto edges = directed_edges(entry);
    EXPECT_EQ(std::set<DirectedEdge>(edges.begin(), edges.end()).size(), edges.size());
  });
}

TEST(CellTable, BoundaryIsTheContours) {
  for_each_row([](CellEntry entry) {
    const auto edges = directed_edges(entry);
    std::set<DirectedEdge> boundary;
    for (const auto& [a, b] : edges) {
      if (edges.count({b, a}) == 0) boundary.insert({a, b});
    }
    EXPECT_EQ(boundary, contour_segments(contours_of(entry)));
  });
}

TEST(CellTable, NoChordLiesInAFaceOfTheCell) {
  for_each_row([](CellEntry entry) {
    const auto contours = contour_segments(contours_of(entry));
    for (const auto& [a, b] : directed_edges(entry)) {
      if (a >= kEdges || b >= kEdges || contours.count({a, b}) > 0 || contours.count({b, a}) > 0) continue;
      EXPECT_EQ(kEdgeFaces[a] & kEdgeFaces[b], 0) << int{a} << '-' << int{b};
    }
  });
}

TEST(CellTable, NoTriangleHasAVertexTwice) {
  for_each_row([](CellEntry entry) {
    for (const CellTriangle& t : table().triangles(entry)) EXPECT_TRUE(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
  });
}

TEST(CellTable, NoTwoTrianglesHaveTheSameVertices) {
  for_each_row([](CellEntry entry) {
    std::set<CellTriangle> seen;
    for (CellTriangle t : table().triangles(entry)) {
      std::sort(t.begin(), t.end());
      EXPECT_TRUE(seen.insert(t).second);
    }
  });
}

TEST(CellTable, VerticesAreTheCrossedEdgesAndTheInteriorOnes) {
  for_each_row([](CellEntry entry) {
    std::set<EdgeIndex> expected;
    for (int edge = 0; edge < kEdges; ++edge) {
      if (is_crossed(table().highs(entry), edge)) expected.insert(static_cast<EdgeIndex>(edge));
    }
    for (std::size_t i = 0; i < table().interior_count(entry); ++i)
      expected.insert(static_cast<EdgeIndex>(kFirstInteriorVertex + i));
    EXPECT_EQ(vertices_of(entry), expected);
  });
}

TEST(CellTable, TrianglesRoundAVertexAreOneFan) {
  for_each_row([](CellEntry entry) {
    for (const EdgeIndex vertex : vertices_of(entry)) {
      std::map<EdgeIndex, EdgeIndex> next;  // round the vertex, along the sides opposite to it
      std::set<EdgeIndex> arrived;
      for (const CellTriangle& t : table().triangles(entry)) {
        for (std::size_t i = 0; i < 3; ++i) {
          if (t[i] != vertex) continue;
          next[t[(i + 1) % 3]] = t[(i + 2) % 3];
          arrived.insert(t[(i + 2) % 3]);
        }
      }
      EdgeIndex at = next.begin()->first;
      for (const auto& [from, to] : next) {
        if (arrived.count(from) == 0) at = from;
      }
      EXPECT_EQ(arrived.count(at) > 0, vertex >= kFirstInteriorVertex) << "closed round interior vertices only";
      std::size_t steps = 0;
      while (next.count(at) > 0 && steps < next.size()) {
        at = next[at];
        ++steps;
      }
      EXPECT_EQ(steps, next.size()) << int{vertex};
    }
  });
}

TEST(CellTable, InteriorVerticesLieAmongTheVerticesRoundThem) {
  for_each_row([](CellEntry entry) {
    for (std::size_t i = 0; i < table().interior_count(entry); ++i) {
      unsigned round = 0;
      for (const auto& [a, b] : directed_edges(entry)) {
        if (a == kFirstInteriorVertex + i && b < kEdges) round |= 1u << b;
      }
      EXPECT_EQ(table().interior_vertices(entry)[i], round);
    }
  });
}

TEST(CellTable, ContoursBoundADiscEachAndTunnelsAnAnnulus) {
  for_each_row([](CellEntry entry) {
    const auto edges = directed_edges(entry);
    std::set<DirectedEdge> undirected;
    for (const auto& [a, b] : edges) undirected.insert(std::minmax(a, b));
    const int euler = static_cast<int>(vertices_of(entry).size()) - static_cast<int>(undirected.size()) +
                      static_cast<int>(table().triangle_count(entry));
    const int contours = contours_of(entry).count;
    const int tunnels = table().has_tunnel(entry) ? 1 : 0;
    EXPECT_EQ(euler, contours - 2 * tunnels);
    EXPECT_EQ(static_cast<int>(components_of(entry).size()), contours - tunnels);
  });
}

TEST(CellTable, TunnelJoinsTheContoursOfItsRimsAndNoOther) {
  for_each_row([](CellEntry entry) {
    if (table().has_tunnel(entry) || !kMayHaveTunnel[table().highs(entry)]) return;
    const Contours contours = contours_of(entry);
    for (std::size_t a = 0; a < contours.count; ++a) {
      for (std::size_t b = 0; b < contours.count; ++b) {
        if (a == b) continue;
        std::set<std::set<EdgeIndex>> expected;
        for (std::size_t i = 0; i < contours.count; ++i) {
          if (i != a && i != b) expected.insert({contours[i].begin(), contours[i].end()});
        }
        std::set<EdgeIndex> annulus(contours[a].begin(), contours[a].end());
        annulus.insert(contours[b].begin(), contours[b].end());
        expected.insert(annulus);
        for (const EdgeIndex rim_a : contours[a]) {
          for (const EdgeIndex rim_b : contours[b]) {
            const CellEntry tunnel = table().with_tunnel(entry, {rim_a, rim_b});
            EXPECT_TRUE(table().has_tunnel(tunnel));
            EXPECT_EQ(table().highs(tunnel), table().highs(entry));
            EXPECT_EQ(table().joined_faces(tunnel), table().joined_faces(entry));
            std::set<std::set<EdgeIndex>> components;
            for (std::set<EdgeIndex> component : components_of(tunnel)) {
              component.erase(component.lower_bound(kFirstInteriorVertex), component.end());
              components.insert(component);
            }
            EXPECT_EQ(components, expected);
          }
        }
      }
    }
  });
}

TEST(CellTable, CellsOfOneContourHaveNoTunnelRow) {
  for_each_row([](CellEntry entry) {
    if (table().has_tunnel(entry)) {
      EXPECT_GE(contours_of(entry).count, 2);
    }
  });
}

TEST(CellTable, ClassicCellsAreOneWordOfTheCaseTable) {
  static_assert(sizeof(PackedTriangles) == sizeof(std::uint64_t));
  for_each_row([](CellEntry entry) {
    const CornerMask highs = table().highs(entry);
    if (!is_tabulated(highs) || table().has_tunnel(entry)) return;
    const PackedTriangles& packed = kCaseTable.triangles[highs][table().joined_faces(entry) != 0 ? 1 : 0];
    ASSERT_LE(packed.size(), PackedTriangles::kMaxTriangles);
    ASSERT_EQ(table().triangle_count(entry), packed.size());
    for (std::size_t i = 0; i < packed.size(); ++i) EXPECT_EQ(table().triangles(entry)[i], packed[i]);
  });
}

TEST(CellTable, OnlyCellsWithSeveralAmbiguousFacesOrATunnelNeedInteriorVertices) {
  for_each_row([](CellEntry entry) {
    if (table().interior_count(entry) == 0) return;
    EXPECT_TRUE(table().has_tunnel(entry) || std::popcount(kAmbiguousFaces[table().highs(entry)]) > 1);
  });
}

TEST(CellTable, StaysSmall) {
  constexpr std::size_t kMaxRows = 1200;
  constexpr std::size_t kMaxTriangleBytes = 32 * 1024;
  std::size_t triangles = 0;
  for_each_row([&](CellEntry entry) { triangles += table().triangle_count(entry); });
  EXPECT_LE(table().size(), kMaxRows);
  EXPECT_LE(triangles * sizeof(CellTriangle), kMaxTriangleBytes);
  RecordProperty("rows", static_cast<int>(table().size()));
  RecordProperty("triangles", static_cast<int>(triangles));
}

}  // namespace
}  // namespace scanknit
