// CellTable: the triangulations of all ways in which a cell can be resolved.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "extract/cell/interior_test.h"
#include "extract/cell/triangulate_cell.h"

namespace scanknit {

/// A row of the table: a case, the resolution of its ambiguous faces, and its tunnel.
using CellEntry = std::uint16_t;

/// About 1,100 rows and 45 KB, which stays in the cache. Tracing the contours of each cell would take longer than
/// everything else.
class CellTable {
 public:
  /// Makes the table at the first call; call it outside of loops.
  [[nodiscard]] static const CellTable& get();

  /// A case, and whether the signs of its corners decide it.
  struct Simple {
    std::uint16_t first_triangle = 0;  ///< of those of a case that needs no values
    std::uint8_t triangle_count = 0;
    bool needs_values = false;  ///< some face is ambiguous, or there may be a tunnel
  };
  [[nodiscard]] const Simple& simple(CornerMask highs) const { return simple_[highs]; }
  [[nodiscard]] std::span<const CellTriangle> triangles(const Simple& simple) const {
    return {triangles_.data() + simple.first_triangle, simple.triangle_count};
  }

  /// A cell without tunnel. `joined_faces`: those ambiguous faces, and no others, whose Highs are joined.
  [[nodiscard]] CellEntry entry(CornerMask highs, FaceMask joined_faces) const { return first_[highs][joined_faces]; }

  /// The same cell with a tunnel between the contours through its two rims; kMayHaveTunnel of the case is true.
  [[nodiscard]] CellEntry with_tunnel(CellEntry entry, const Tunnel& tunnel) const;

  [[nodiscard]] std::span<const CellTriangle> triangles(CellEntry entry) const {
    return std::span(triangles_).subspan(rows_[entry].first_triangle, rows_[entry].triangle_count);
  }
  [[nodiscard]] std::uint8_t triangle_count(CellEntry entry) const { return rows_[entry].triangle_count; }
  [[nodiscard]] std::uint8_t interior_count(CellEntry entry) const { return rows_[entry].interior_count; }

  /// For each interior vertex the edges in whose middle it lies.
  [[nodiscard]] std::span<const EdgeMask> interior_vertices(CellEntry entry) const {
    return std::span(rows_[entry].interior).first(rows_[entry].interior_count);
  }

  [[nodiscard]] CornerMask highs(CellEntry entry) const { return rows_[entry].highs; }
  [[nodiscard]] FaceMask joined_faces(CellEntry entry) const { return rows_[entry].joined_faces; }
  [[nodiscard]] bool has_tunnel(CellEntry entry) const { return rows_[entry].has_tunnel; }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }

 private:
  struct Row {
    std::uint16_t first_triangle = 0;
    std::uint8_t triangle_count = 0;
    std::uint8_t interior_count = 0;
    std::array<EdgeMask, CellTriangles::kMaxInterior> interior{};
    CornerMask highs = 0;
    FaceMask joined_faces = 0;
    bool has_tunnel = false;
  };

  CellTable();
  void add(CornerMask highs, FaceMask joined_faces, const CellTriangles& triangles, bool has_tunnel);

  std::array<Simple, 256> simple_{};
  std::array<std::array<CellEntry, 64>, 256> first_{};
  std::vector<Row> rows_;
  std::vector<CellTriangle> triangles_;
};

}  // namespace scanknit
