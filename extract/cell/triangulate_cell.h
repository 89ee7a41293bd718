// One cell: which corners are High, how its ambiguous faces are resolved, what its tunnel joins -> triangles. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "extract/cell/case_table.h"
#include "extract/cell/contours.h"

namespace scanknit {

/// A set of a cell's edges: bit e.
using EdgeMask = std::uint16_t;

/// A cell's triangles, counter-clockwise seen from the Lows.
class CellTriangles {
 public:
  /// Round one interior vertex every crossed edge gives a triangle; an annulus cut in two by two chords gives four
  /// more.
  static constexpr std::size_t kMaxTriangles = kEdges + 4;
  static constexpr std::size_t kMaxInterior = 2;

  constexpr void push_back(const CellTriangle& t) { triangles_[size_++] = t; }
  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr const CellTriangle* begin() const { return triangles_.data(); }
  [[nodiscard]] constexpr const CellTriangle* end() const { return triangles_.data() + size_; }

  /// For each interior vertex, kFirstInteriorVertex and up, the edges in whose middle it lies.
  [[nodiscard]] constexpr std::span<const EdgeMask> interior_vertices() const {
    return std::span(interior_).first(interior_size_);
  }

  /// A closed polygon becomes a fan round a new interior vertex.
  constexpr void push_fan(std::span<const EdgeIndex> polygon) {
    const auto centre = static_cast<EdgeIndex>(kFirstInteriorVertex + interior_size_);
    unsigned edges = 0;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      edges |= 1u << polygon[k];
      push_back({polygon[k], polygon[(k + 1) % polygon.size()], centre});
    }
    interior_[interior_size_++] = static_cast<EdgeMask>(edges);
  }

 private:
  std::array<CellTriangle, kMaxTriangles> triangles_{};
  std::size_t size_ = 0;
  std::array<EdgeMask, kMaxInterior> interior_{};
  std::size_t interior_size_ = 0;
};

/// One disc: by chords inside the cell where such a triangulation exists, else a fan round an interior vertex.
constexpr void triangulate_disc(std::span<const EdgeIndex> contour, CellTriangles& triangles) {
  const PolygonCuts cuts(contour);
  if (cuts.exists()) {
    cuts.write(0, contour.size() - 1, triangles);
  } else {
    triangles.push_fan(contour);
  }
}

/// One annulus between two contours; both run as the surface's boundary does, so that along the annulus the second runs
/// backwards. A strip of triangles whose chords lie inside the cell, each chord once, where there is one; else two such
/// chords cut the annulus into two polygons with a fan each.
class Annulus {
 public:
  constexpr Annulus(std::span<const EdgeIndex> a, std::span<const EdgeIndex> b) : a_(a), b_(b) {}

  constexpr void triangulate(CellTriangles& triangles) {
    for (std::size_t start = 0; start < b_.size(); ++start) {
      if (!is_chord_inside_cell(a_[0], b_[start])) continue;
      start_ = start;
      if (find_strip(0, 0)) return write_strip(triangles);
    }
    cut_in_two(triangles);
  }

 private:
  /// The chord after `i` steps along the first contour and `j` steps back along the second.
  [[nodiscard]] constexpr EdgeIndex on_a(std::size_t i) const { return a_[i % a_.size()]; }
  [[nodiscard]] constexpr EdgeIndex on_b(std::size_t j) const { return b_[(start_ + 2 * b_.size() - j) % b_.size()]; }
  [[nodiscard]] constexpr bool is_allowed(std::size_t i, std::size_t j) const {
    // All round one contour while the other stands still would come back to a chord that is drawn already.
    const bool closes_early = (i == a_.size()) != (j == b_.size()) && (i == 0 || j == 0);
    return !closes_early && is_chord_inside_cell(on_a(i), on_b(j));
  }

  /// Extends the strip from the chord (i, j) until it is closed; tries first to keep the two contours in step.
  constexpr bool find_strip(std::size_t i, std::size_t j) {
    if (i == a_.size() && j == b_.size()) return !stands_still();
    const bool a_is_behind = i * b_.size() <= j * a_.size();
    for (const bool along_a : {a_is_behind, !a_is_behind}) {
      const std::size_t next_i = i + (along_a ? 1 : 0);
      const std::size_t next_j = j + (along_a ? 0 : 1);
      if (next_i > a_.size() || next_j > b_.size() || !is_allowed(next_i, next_j)) continue;
      steps_along_a_[i + j] = along_a;
      if (find_strip(next_i, next_j)) return true;
    }
    return false;
  }

  /// All the steps along one contour come one after the other: the first chord and the last of them are the same.
  [[nodiscard]] constexpr bool stands_still() const {
    std::size_t changes = 0;
    const std::size_t steps = a_.size() + b_.size();
    for (std::size_t k = 0; k < steps; ++k) changes += steps_along_a_[k] != steps_along_a_[(k + 1) % steps] ? 1 : 0;
    return changes <= 2;
  }

  constexpr void write_strip(CellTriangles& triangles) const {
    std::size_t i = 0;
    std::size_t j = 0;
    while (i + j < a_.size() + b_.size()) {
      if (steps_along_a_[i + j]) {
        triangles.push_back({on_a(i), on_a(i + 1), on_b(j)});
        ++i;
      } else {
        triangles.push_back({on_b(j + 1), on_b(j), on_a(i)});
        ++j;
      }
    }
  }

  constexpr void cut_in_two(CellTriangles& triangles) const {
    for (std::size_t i = 0; i < a_.size(); ++i) {
      for (std::size_t j = 0; j < b_.size(); ++j) {
        for (std::size_t k = i + 1; k < a_.size(); ++k) {
          for (std::size_t l = 0; l < b_.size(); ++l) {
            if (l == j || !is_chord_inside_cell(a_[i], b_[j]) || !is_chord_inside_cell(a_[k], b_[l])) continue;
            push_part(i, k, l, j, triangles);
            push_part(k, i, j, l, triangles);
            return;
          }
        }
      }
    }
  }

  /// The polygon from `a_from` on to `a_to`, across, from `b_from` on to `b_to`, and back across.
  constexpr void push_part(std::size_t a_from, std::size_t a_to, std::size_t b_from, std::size_t b_to,
                           CellTriangles& triangles) const {
    std::array<EdgeIndex, kEdges> polygon{};
    std::size_t size = 0;
    for (std::size_t i = a_from;; i = (i + 1) % a_.size()) {
      polygon[size++] = a_[i];
      if (i == a_to) break;
    }
    for (std::size_t i = b_from;; i = (i + 1) % b_.size()) {
      polygon[size++] = b_[i];
      if (i == b_to) break;
    }
    triangles.push_fan(std::span(polygon).first(size));
  }

  std::span<const EdgeIndex> a_;
  std::span<const EdgeIndex> b_;
  std::size_t start_ = 0;  ///< where on the second contour the first chord ends
  std::array<bool, kEdges> steps_along_a_{};
};

/// Two contours of a cell that are the rims of one annulus; equal: there is none.
struct Rims {
  std::size_t a = 0;
  std::size_t b = 0;
};

/// One disc in each contour, one annulus between the rims.
[[nodiscard]] constexpr CellTriangles triangulate_contours(const Contours& contours, Rims rims = {}) {
  CellTriangles triangles;
  const bool has_tunnel = rims.a != rims.b;
  if (has_tunnel) Annulus(contours[rims.a], contours[rims.b]).triangulate(triangles);
  for (std::size_t i = 0; i < contours.count; ++i) {
    if (!has_tunnel || (i != rims.a && i != rims.b)) triangulate_disc(contours[i], triangles);
  }
  return triangles;
}

/// A cell without tunnel. `joined_faces`: the ambiguous faces whose Highs are joined.
[[nodiscard]] constexpr CellTriangles triangulate_cell(CornerMask highs, FaceMask joined_faces) {
  if (!is_tabulated(highs)) return triangulate_contours(trace_contours(highs, joined_faces));
  CellTriangles triangles;
  const PackedTriangles& packed = kCaseTable.triangles[highs][joined_faces != 0];
  for (std::size_t i = 0; i < packed.size(); ++i) triangles.push_back(packed[i]);
  return triangles;
}

}  // namespace scanknit
