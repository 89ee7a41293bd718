// THE numbering of a cell's corners, edges and faces. Nothing else in the project may number them.
//
//               6 ---- x3 ---- 7
//              /|             /|          corner = x + 2y + 4z
//            y2 |           y3 |          edge   = 4 axis + j, written here as axis and j:
//            /  z2          /  z3              x-edges 0-3:  j = y + 2z
//           4 ---- x2 ---- 5   |               y-edges 4-7:  j = x + 2z
//      z    |   |          |   |               z-edges 8-11: j = x + 2y
//      |  y |   2 ---- x1 -|-- 3          face   = 2 axis + side: -x +x -y +y -z +z
//      | /  z0 /          z1  /
//      |/   | y0           | y1           A cell is named after the voxel at its corner 0.
//      +--x |/             |/
//           0 ---- x0 ---- 1
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace scanknit {

inline constexpr int kCorners = 8;
inline constexpr int kEdges = 12;
inline constexpr int kFaces = 6;

/// Bit i is set when corner i is High (value >= isovalue).
using CornerMask = std::uint8_t;
/// Bit f is set for face f.
using FaceMask = std::uint8_t;
/// The 4 bits of an edge's number; 12 and above name interior vertices (triangulate_cell.h).
using EdgeIndex = std::uint8_t;

/// 0 or 1: the coordinate of a corner along an axis.
[[nodiscard]] constexpr int corner_coordinate(int corner, int axis) {
  return (corner >> axis) & 1;
}

[[nodiscard]] constexpr bool is_high(CornerMask highs, int corner) {
  return ((highs >> corner) & 1) != 0;
}

[[nodiscard]] constexpr int edge_axis(int edge) {
  return edge / 4;
}

/// The end of an edge with the smaller coordinates: the two bits of j, with a 0 inserted at the edge's axis.
[[nodiscard]] constexpr int edge_low_corner(int edge) {
  const int axis = edge_axis(edge);
  const int j = edge % 4;
  const int below = j & ((1 << axis) - 1);
  return below | ((j ^ below) << 1);
}

[[nodiscard]] constexpr int edge_high_corner(int edge) {
  return edge_low_corner(edge) | (1 << edge_axis(edge));
}

/// The edge between two corners that differ in one coordinate: the inverse of edge_low_corner.
[[nodiscard]] constexpr int edge_between(int corner_a, int corner_b) {
  const int along = corner_a ^ corner_b;  // 1, 2 or 4
  const int axis = along >> 1;
  const int low = corner_a & corner_b;
  const int below = low & (along - 1);
  return 4 * axis + (below | ((low ^ below) >> 1));
}

[[nodiscard]] constexpr bool is_crossed(CornerMask highs, int edge) {
  return is_high(highs, edge_low_corner(edge)) != is_high(highs, edge_high_corner(edge));
}

/// The four corners of each face, counter-clockwise seen from outside the cell.
inline constexpr auto kFaceCorners = [] {
  std::array<std::array<int, 4>, kFaces> corners{};
  for (int face = 0; face < kFaces; ++face) {
    const int axis = face / 2;
    const int side = face % 2;
    const int u = 1 << ((axis + 1) % 3);
    const int v = 1 << ((axis + 2) % 3);
    const int origin = side << axis;
    corners[static_cast<std::size_t>(face)] = side == 1 ? std::array{origin, origin + u, origin + u + v, origin + v}
                                                        : std::array{origin, origin + v, origin + u + v, origin + u};
  }
  return corners;
}();

/// The four corners of each face in cyclic order, the same for the two cells that share it: their values in this order
/// give both cells the same bits.
inline constexpr auto kFaceRing = [] {
  auto ring = kFaceCorners;
  for (std::size_t face = 0; face < kFaces; face += 2) std::swap(ring[face][1], ring[face][3]);
  return ring;
}();

/// The two faces that an edge lies in.
inline constexpr auto kEdgeFaces = [] {
  std::array<FaceMask, kEdges> faces{};
  for (int edge = 0; edge < kEdges; ++edge) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == edge_axis(edge)) continue;
      const int face = 2 * axis + corner_coordinate(edge_low_corner(edge), axis);
      faces[static_cast<std::size_t>(edge)] |= static_cast<FaceMask>(1 << face);
    }
  }
  return faces;
}();

/// The faces whose Highs lie on one diagonal and whose Lows lie on the other, for each of the 256 cases.
inline constexpr auto kAmbiguousFaces = [] {
  std::array<FaceMask, 256> faces{};
  for (unsigned highs = 0; highs < 256; ++highs) {
    for (int face = 0; face < kFaces; ++face) {
      const auto& c = kFaceCorners[static_cast<std::size_t>(face)];
      const auto high = [&](std::size_t i) { return is_high(static_cast<CornerMask>(highs), c[i]); };
      if (high(0) == high(2) && high(1) == high(3) && high(0) != high(1))
        faces[highs] |= static_cast<FaceMask>(1 << face);
    }
  }
  return faces;
}();

}  // namespace scanknit
