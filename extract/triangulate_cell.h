// One cell: which corners are High and how its ambiguous faces are resolved -> triangles. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "extract/case_table.h"
#include "extract/contours.h"

namespace scanknit {

/// A small vector of a cell's triangles. At most twelve: every crossed edge gives one triangle round an interior vertex
/// at the most.
class CellTriangles {
 public:
  constexpr void push_back(const CellTriangle& t) { triangles_[size_++] = t; }
  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr const CellTriangle* begin() const { return triangles_.data(); }
  [[nodiscard]] constexpr const CellTriangle* end() const { return triangles_.data() + size_; }

  /// The contour round the interior vertex (kFirstInteriorVertex), empty when there is none. There is at most one: only
  /// contours of eight edges and more need it, and a cell has twelve edges.
  [[nodiscard]] constexpr std::span<const EdgeIndex> interior_contour() const {
    return std::span(contour_).first(contour_size_);
  }
  constexpr void set_interior_contour(std::span<const EdgeIndex> contour) {
    contour_size_ = contour.size();
    for (std::size_t i = 0; i < contour_size_; ++i) contour_[i] = contour[i];
  }

 private:
  std::array<CellTriangle, kEdges> triangles_{};
  std::size_t size_ = 0;
  std::array<EdgeIndex, kEdges> contour_{};
  std::size_t contour_size_ = 0;
};

/// One disc in each contour: by chords inside the cell where such a triangulation exists, else as a fan round an
/// interior vertex. Counter-clockwise seen from the Lows.
[[nodiscard]] constexpr CellTriangles triangulate_contours(const Contours& contours) {
  CellTriangles triangles;
  for (std::size_t i = 0; i < contours.count; ++i) {
    const auto contour = contours[i];
    const PolygonCuts cuts(contour);
    if (cuts.exists()) {
      cuts.write(0, contour.size() - 1, triangles);
      continue;
    }
    triangles.set_interior_contour(contour);
    for (std::size_t k = 0; k < contour.size(); ++k)
      triangles.push_back({contour[k], contour[(k + 1) % contour.size()], kFirstInteriorVertex});
  }
  return triangles;
}

/// `joined_faces`: the ambiguous faces whose Highs are joined.
[[nodiscard]] constexpr CellTriangles triangulate_cell(CornerMask highs, FaceMask joined_faces) {
  if (!is_tabulated(highs)) return triangulate_contours(trace_contours(highs, joined_faces));
  CellTriangles triangles;
  const PackedTriangles& packed = kCaseTable.triangles[highs][joined_faces != 0];
  for (std::size_t i = 0; i < packed.size(); ++i) triangles.push_back(packed[i]);
  return triangles;
}

}  // namespace scanknit
