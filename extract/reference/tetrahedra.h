// A cell as tetrahedra, three ways, and the surface in one tetrahedron. Numbering of corners and faces: cell.h.
//
// Marching tetrahedra: Doi & Koide 1991. The three decompositions and what each does to the isosurface are compared by
// Carr, Moeller & Snoeyink 2006 (Artifacts caused by simplicial subdivision).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "extract/cell/cell.h"

namespace scanknit {

enum class TetraSplit {
  k5,   ///< a regular tetrahedron and a corner off each of its sides; two kinds that alternate (Payne & Toga 1990)
  k6,   ///< round the main diagonal from corner 0 to 7, one kind everywhere (Freudenthal 1942, Kuhn 1960)
  k24,  ///< from the centre to each half side of each face: as symmetric as the cell
};

/// A point of a cell: its corner 0-7, the middle 8-13 of its face 0-5, or its centre 14.
using CellPoint = std::uint8_t;
inline constexpr int kFirstFacePoint = kCorners;
inline constexpr int kCentrePoint = kCorners + kFaces;
inline constexpr int kCellPoints = kCentrePoint + 1;

/// In half cells from corner 0: 0, 1 or 2.
[[nodiscard]] constexpr int half_coordinate(int point, int axis) {
  if (point < kFirstFacePoint) return 2 * corner_coordinate(point, axis);
  const int face = point - kFirstFacePoint;
  return point < kCentrePoint && face / 2 == axis ? 2 * (face % 2) : 1;
}

/// The corners whose mean is the value at a point: itself, the face's four, or all eight.
inline constexpr auto kCornersOfPoint = [] {
  std::array<CornerMask, kCellPoints> corners{};
  for (int point = 0; point < kCellPoints; ++point) {
    for (int corner = 0; corner < kCorners; ++corner) {
      bool is_one = true;
      for (int axis = 0; axis < 3; ++axis) {
        const int half = half_coordinate(point, axis);
        is_one = is_one && (half == 1 || half == half_coordinate(corner, axis));
      }
      if (is_one) corners[static_cast<std::size_t>(point)] |= static_cast<CornerMask>(1 << corner);
    }
  }
  return corners;
}();

/// Four points, the first three counter-clockwise seen from the fourth.
using Tetra = std::array<CellPoint, 4>;

/// Six times the volume, in cubic half cells; positive for the orientation that Tetra promises.
[[nodiscard]] constexpr int six_volumes(const Tetra& tetra) {
  std::array<std::array<int, 3>, 3> side{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      side[i][static_cast<std::size_t>(axis)] = half_coordinate(tetra[i + 1], axis) - half_coordinate(tetra[0], axis);
  }
  int determinant = 0;
  for (std::size_t i = 0; i < 3; ++i)
    determinant += side[0][i] * (side[1][(i + 1) % 3] * side[2][(i + 2) % 3] -  //
                                 side[1][(i + 2) % 3] * side[2][(i + 1) % 3]);
  return determinant;
}

[[nodiscard]] constexpr Tetra oriented(int a, int b, int c, int d) {
  Tetra tetra{static_cast<CellPoint>(a), static_cast<CellPoint>(b), static_cast<CellPoint>(c),
              static_cast<CellPoint>(d)};
  if (six_volumes(tetra) < 0) std::swap(tetra[2], tetra[3]);
  return tetra;
}

/// kTetra5[p]: the corners whose coordinates' sum has parity p span the regular tetrahedron, the others are cut off.
/// Every face diagonal joins corners of parity p; neighbours agree when p is the parity of the cell's own x + y + z.
inline constexpr auto kTetra5 = [] {
  std::array<std::array<Tetra, 5>, 2> kinds{};
  for (int parity = 0; parity < 2; ++parity) {
    auto tetra = kinds[static_cast<std::size_t>(parity)].begin();
    *tetra++ = oriented(parity, 3 ^ parity, 5 ^ parity, 6 ^ parity);
    for (const int inner : {0, 3, 5, 6}) {
      const int cut = inner ^ parity ^ 1;
      *tetra++ = oriented(cut, cut ^ 1, cut ^ 2, cut ^ 4);
    }
  }
  return kinds;
}();

/// One tetrahedron for each order of the axes: the path along them from corner 0 to corner 7.
inline constexpr auto kTetra6 = [] {
  std::array<Tetra, 6> tetrahedra{};
  auto tetra = tetrahedra.begin();
  for (int first = 0; first < 3; ++first) {
    for (const int turn : {1, 2}) {
      const int second = (first + turn) % 3;
      *tetra++ = oriented(0, 1 << first, (1 << first) | (1 << second), 7);
    }
  }
  return tetrahedra;
}();

/// One tetrahedron for each side of each face: the side, the face's middle and the centre.
inline constexpr auto kTetra24 = [] {
  std::array<Tetra, 24> tetrahedra{};
  auto tetra = tetrahedra.begin();
  for (int face = 0; face < kFaces; ++face) {
    const auto& corner = kFaceCorners[static_cast<std::size_t>(face)];
    for (std::size_t i = 0; i < 4; ++i)
      *tetra++ = oriented(corner[i], corner[(i + 1) % 4], kFirstFacePoint + face, kCentrePoint);
  }
  return tetrahedra;
}();

[[nodiscard]] constexpr bool fills_cell(std::span<const Tetra> tetrahedra) {
  int sum = 0;
  for (const Tetra& tetra : tetrahedra) {
    if (six_volumes(tetra) <= 0) return false;
    sum += six_volumes(tetra);
  }
  return sum == 6 * 2 * 2 * 2;
}
static_assert(fills_cell(kTetra5[0]) && fills_cell(kTetra5[1]) && fills_cell(kTetra6) && fills_cell(kTetra24));

/// `parity`: of the cell's x + y + z, 0 or 1.
[[nodiscard]] constexpr std::span<const Tetra> tetrahedra(TetraSplit split, std::size_t parity) {
  if (split == TetraSplit::k5) return kTetra5[parity];
  if (split == TetraSplit::k6) return kTetra6;
  return kTetra24;
}

/// How many of the CellPoints the decomposition uses: 8, or all 15.
[[nodiscard]] constexpr int cell_points(TetraSplit split) {
  return split == TetraSplit::k24 ? kCellPoints : kCorners;
}

/// The surface in a tetrahedron: a polygon of three or four vertices, each on the edge between two of the
/// tetrahedron's positions 0-3. Counter-clockwise seen from the Lows.
struct TetraPolygon {
  std::array<std::array<std::uint8_t, 2>, 4> edges{};
  std::size_t size = 0;
};

/// For each set of High positions. The positions are sorted Highs first by exchanges of neighbours; after an odd number
/// of them two of one colour are exchanged as well, which keeps the orientation. Then the three cases need no table.
inline constexpr auto kTetraPolygons = [] {
  std::array<TetraPolygon, 16> polygons{};
  for (unsigned highs = 0; highs < 16; ++highs) {
    std::array<std::uint8_t, 4> p{0, 1, 2, 3};
    const auto is_high_at = [&](std::size_t i) { return ((highs >> p[i]) & 1) != 0; };
    bool is_odd = false;
    for (std::size_t last = 3; last > 0; --last) {
      for (std::size_t i = 0; i < last; ++i) {
        if (is_high_at(i) || !is_high_at(i + 1)) continue;
        std::swap(p[i], p[i + 1]);
        is_odd = !is_odd;
      }
    }
    const std::size_t twin = is_high_at(1) ? 0 : 2;
    if (is_odd) std::swap(p[twin], p[twin + 1]);

    if (highs == 0 || highs == 15) continue;
    if (!is_high_at(1))
      polygons[highs] = {{{{p[0], p[1]}, {p[0], p[2]}, {p[0], p[3]}}}, 3};
    else if (!is_high_at(2))
      polygons[highs] = {{{{p[0], p[2]}, {p[0], p[3]}, {p[1], p[3]}, {p[1], p[2]}}}, 4};
    else
      polygons[highs] = {{{{p[0], p[3]}, {p[1], p[3]}, {p[2], p[3]}}}, 3};
  }
  return polygons;
}();

}  // namespace scanknit
