// Contours: where the isosurface meets the boundary of a cell, as closed polygons of crossed edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "extract/cell/cell.h"

namespace scanknit {

/// At most four closed polygons of at least three crossed edges each; every crossed edge is in exactly one.
/// They run counter-clockwise round their High side's complement: a triangle (a, b, c) of consecutive edges is
/// counter-clockwise seen from the Lows.
struct Contours {
  std::array<EdgeIndex, kEdges> edges{};  ///< the polygons one after the other
  std::array<std::uint8_t, 5> begin{};    ///< polygon i is edges[begin[i]] to edges[begin[i + 1]]
  std::uint8_t count = 0;

  [[nodiscard]] constexpr std::span<const EdgeIndex> operator[](std::size_t i) const {
    return std::span(edges).subspan(begin[i], static_cast<std::size_t>(begin[i + 1] - begin[i]));
  }
};

/// The edge that follows each crossed edge along its contour. Walk round a face counter-clockwise, seen from outside:
/// the border goes `up` (from Low to High) through one edge and `down` through another. A contour runs from the up edge
/// to a down edge: to the next one, cutting off the High between them; or, where the Highs are joined, to the
/// previous one, cutting off the Low. The two faces of an edge are walked in opposite directions: up in one is down in
/// the other, hence every crossed edge has one successor and one predecessor.
[[nodiscard]] constexpr std::array<EdgeIndex, kEdges> contour_successors(CornerMask highs, FaceMask joined_faces) {
  std::array<EdgeIndex, kEdges> successor{};
  for (std::size_t face = 0; face < kFaces; ++face) {
    const auto& corner = kFaceCorners[face];
    const std::size_t step = ((joined_faces & kAmbiguousFaces[highs]) >> face) & 1 ? 3 : 1;  // 3: backwards
    const auto high = [&](std::size_t i) { return is_high(highs, corner[i % 4]); };
    for (std::size_t up = 0; up < 4; ++up) {
      if (high(up) || !high(up + 1)) continue;
      std::size_t down = up + step;
      while (!high(down) || high(down + 1)) down += step;
      const auto edge = [&](std::size_t i) { return edge_between(corner[i % 4], corner[(i + 1) % 4]); };
      successor[static_cast<std::size_t>(edge(up))] = static_cast<EdgeIndex>(edge(down));
    }
  }
  return successor;
}

/// `joined_faces`: the ambiguous faces whose Highs are joined; bits of other faces are ignored.
[[nodiscard]] constexpr Contours trace_contours(CornerMask highs, FaceMask joined_faces) {
  const auto successor = contour_successors(highs, joined_faces);
  Contours contours;
  std::uint8_t length = 0;
  unsigned visited = 0;
  for (unsigned start = 0; start < kEdges; ++start) {
    if (((visited >> start) & 1) != 0 || !is_crossed(highs, static_cast<int>(start))) continue;
    for (unsigned edge = start; ((visited >> edge) & 1) == 0; edge = successor[edge]) {
      visited |= 1u << edge;
      contours.edges[length++] = static_cast<EdgeIndex>(edge);
    }
    contours.begin[++contours.count] = length;
  }
  return contours;
}

}  // namespace scanknit
