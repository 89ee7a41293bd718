// One contour becomes one disc of triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "extract/cell/cell.h"

namespace scanknit {

/// Three of a cell's vertices: edges 0 to 11, or kFirstInteriorVertex and up.
using CellTriangle = std::array<EdgeIndex, 3>;

/// Interior vertices of a cell are numbered after its twelve edges.
inline constexpr EdgeIndex kFirstInteriorVertex = kEdges;

/// A chord between two edges of the same face would lie in that face. The neighbouring cell may well draw the same
/// chord, and its edge would have four triangles: the defect of the published exact codes on noise. Such chords are
/// never drawn.
[[nodiscard]] constexpr bool is_chord_inside_cell(EdgeIndex a, EdgeIndex b) {
  return (kEdgeFaces[a] & kEdgeFaces[b]) == 0;
}

/// The ways to cut a polygon of n <= 12 corners into n - 2 triangles by chords inside the cell.
class PolygonCuts {
 public:
  constexpr explicit PolygonCuts(std::span<const EdgeIndex> polygon) : polygon_(polygon) {
    const std::size_t n = polygon.size();
    for (std::size_t length = 2; length < n; ++length) {
      for (std::size_t i = 0; i + length < n; ++i) apex_[i][i + length] = find_apex(i, i + length);
    }
  }

  [[nodiscard]] constexpr bool exists() const { return apex_[0][polygon_.size() - 1] != 0; }

  /// The triangles of the part between corners i and j, by the first apex found.
  template <typename Output>
  constexpr void write(std::size_t i, std::size_t j, Output& output) const {
    if (j - i < 2) return;
    const std::size_t k = apex_[i][j];
    output.push_back(CellTriangle{polygon_[i], polygon_[k], polygon_[j]});
    write(i, k, output);
    write(k, j, output);
  }

 private:
  [[nodiscard]] constexpr bool is_side(std::size_t i, std::size_t j) const {
    return j - i == 1 || (i == 0 && j + 1 == polygon_.size());
  }
  /// The part i..j of the polygon can be cut, and its chord (i, j) may be drawn.
  [[nodiscard]] constexpr bool is_cut(std::size_t i, std::size_t j) const { return j - i == 1 || apex_[i][j] != 0; }

  /// The corner that makes a triangle with i and j, nearest to the middle so that triangles are not slivers; 0: none.
  [[nodiscard]] constexpr std::uint8_t find_apex(std::size_t i, std::size_t j) const {
    if (!is_side(i, j) && !is_chord_inside_cell(polygon_[i], polygon_[j])) return 0;
    const std::size_t middle = (i + j) / 2;
    for (std::size_t step = 0; step < j - i; ++step) {
      const std::size_t k = step % 2 == 0 ? middle - step / 2 : middle + (step + 1) / 2;
      if (k > i && k < j && is_cut(i, k) && is_cut(k, j)) return static_cast<std::uint8_t>(k);
    }
    return 0;
  }

  std::span<const EdgeIndex> polygon_;
  std::array<std::array<std::uint8_t, kEdges>, kEdges> apex_{};
};

}  // namespace scanknit
