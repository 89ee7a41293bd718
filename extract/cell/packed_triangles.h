// PackedTriangles: up to five triangles of a cell in one 64-bit word.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "extract/cell/cube_symmetry.h"
#include "extract/cell/triangulate_contour.h"

namespace scanknit {

/// 5 triangles x 3 edges x 4 bits, and their number in the 4 bits that are left. Triangles are counter-clockwise seen
/// from the Lows.
class PackedTriangles {
 public:
  static constexpr std::size_t kMaxTriangles = 5;

  constexpr PackedTriangles() = default;
  constexpr PackedTriangles(std::initializer_list<CellTriangle> triangles) {
    for (const CellTriangle& t : triangles) push_back(t);
  }

  [[nodiscard]] constexpr std::size_t size() const { return static_cast<std::size_t>(word_ >> kSizeShift); }

  [[nodiscard]] constexpr CellTriangle operator[](std::size_t i) const {
    const std::uint64_t bits = word_ >> (kTriangleBits * i);
    return {static_cast<EdgeIndex>(bits & 15), static_cast<EdgeIndex>((bits >> 4) & 15),
            static_cast<EdgeIndex>((bits >> 8) & 15)};
  }

  /// At most kMaxTriangles; a sixth does not compile, and aborts nothing: tables are built at compile time only.
  constexpr void push_back(const CellTriangle& t) {
    const std::uint64_t bits = t[0] | (std::uint64_t{t[1]} << 4) | (std::uint64_t{t[2]} << 8);
    word_ += (bits << (kTriangleBits * size())) + (std::uint64_t{1} << kSizeShift);
  }

  constexpr bool operator==(const PackedTriangles&) const = default;

 private:
  static constexpr unsigned kTriangleBits = 12;
  static constexpr unsigned kSizeShift = 60;
  std::uint64_t word_ = 0;
};

/// The orientation is repaired under reflection: triangles stay counter-clockwise seen from the Lows.
[[nodiscard]] constexpr PackedTriangles transformed(const PackedTriangles& triangles, const CubeSymmetry& symmetry) {
  PackedTriangles moved;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const CellTriangle t = triangles[i];
    const CellTriangle to{symmetry.edge[t[0]], symmetry.edge[t[1]], symmetry.edge[t[2]]};
    moved.push_back(symmetry.is_mirror ? CellTriangle{to[0], to[2], to[1]} : to);
  }
  return moved;
}

/// The same triangles seen from the other side: Lows have become Highs.
[[nodiscard]] constexpr PackedTriangles colour_flipped(const PackedTriangles& triangles) {
  PackedTriangles flipped;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const CellTriangle t = triangles[i];
    flipped.push_back({t[0], t[2], t[1]});
  }
  return flipped;
}

}  // namespace scanknit
