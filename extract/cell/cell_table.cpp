#include "extract/cell/cell_table.h"

#include <algorithm>

#include "core/check.h"

namespace scanknit {
namespace {

/// Which contour passes through an edge.
std::size_t contour_of(const Contours& contours, EdgeIndex edge) {
  for (std::size_t i = 0; i < contours.count; ++i) {
    if (std::find(contours[i].begin(), contours[i].end(), edge) != contours[i].end()) return i;
  }
  return contours.count;
}

/// Pairs a < b in the order (0, 1), (0, 2), (1, 2), (0, 3) ...
constexpr std::size_t pair_number(std::size_t a, std::size_t b) {
  return b * (b - 1) / 2 + a;
}

}  // namespace

const CellTable& CellTable::get() {
  static const CellTable table;
  return table;
}

CellTable::CellTable() {
  for (unsigned case_number = 0; case_number < 256; ++case_number) {
    const auto highs = static_cast<CornerMask>(case_number);
    const auto first_triangle = static_cast<std::uint16_t>(triangles_.size());
    simple_[highs] = {first_triangle, static_cast<std::uint8_t>(triangulate_cell(highs, 0).size()),
                      kAmbiguousFaces[highs] != 0 || kMayHaveTunnel[highs]};
    for (unsigned faces = 0; faces < 64; ++faces) {
      const auto joined = static_cast<FaceMask>(faces);
      if ((joined & ~kAmbiguousFaces[highs]) != 0) continue;
      first_[highs][joined] = static_cast<CellEntry>(rows_.size());
      add(highs, joined, triangulate_cell(highs, joined), false);
      if (!kMayHaveTunnel[highs]) continue;
      const Contours contours = trace_contours(highs, joined);
      for (std::size_t b = 1; b < contours.count; ++b) {
        for (std::size_t a = 0; a < b; ++a) add(highs, joined, triangulate_contours(contours, {a, b}), true);
      }
    }
  }
}

void CellTable::add(CornerMask highs, FaceMask joined_faces, const CellTriangles& triangles, bool has_tunnel) {
  Row row;
  row.first_triangle = static_cast<std::uint16_t>(triangles_.size());
  row.triangle_count = static_cast<std::uint8_t>(triangles.size());
  const auto interior = triangles.interior_vertices();
  row.interior_count = static_cast<std::uint8_t>(interior.size());
  std::copy(interior.begin(), interior.end(), row.interior.begin());
  row.highs = highs;
  row.joined_faces = joined_faces;
  row.has_tunnel = has_tunnel;
  rows_.push_back(row);
  triangles_.insert(triangles_.end(), triangles.begin(), triangles.end());
  SCANKNIT_CHECK(triangles_.size() <= 0xFFFF);
}

CellEntry CellTable::with_tunnel(CellEntry entry, const Tunnel& tunnel) const {
  const Contours contours = trace_contours(highs(entry), joined_faces(entry));
  const std::size_t a = contour_of(contours, tunnel.rim_a);
  const std::size_t b = contour_of(contours, tunnel.rim_b);
  SCANKNIT_CHECK(a != b && a < contours.count && b < contours.count);
  return static_cast<CellEntry>(entry + 1 + pair_number(std::min(a, b), std::max(a, b)));
}

}  // namespace scanknit
