// The interior test: does a tunnel join two contours of a cell?
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "extract/cell/cell.h"

namespace scanknit {

/// The samples at a cell's corners, each minus the isovalue.
using CellValues = std::array<double, kCorners>;

/// The cell's four edges along an axis, in cyclic order round it, each by its low corner.
[[nodiscard]] constexpr std::array<int, 4> columns_along(int axis) {
  const int u = 1 << ((axis + 1) % 3);
  const int v = 1 << ((axis + 2) % 3);
  return {0, u, u + v, v};
}

/// Where a tunnel is possible at all: whatever axis one cuts the cell across, some of the cuts alternate (two opposite
/// columns are High there, the other two Low), and there are two contours to join, or more.
inline constexpr auto kMayHaveTunnel = [] {
  std::array<bool, 256> may{};
  for (unsigned highs = 0; highs < 256; ++highs) {
    may[highs] = true;
    for (int axis = 0; axis < 3; ++axis) {
      const auto columns = columns_along(axis);
      const auto has = [&](std::size_t column, bool high) {
        const auto mask = static_cast<CornerMask>(highs);
        return is_high(mask, columns[column]) == high || is_high(mask, columns[column] | (1 << axis)) == high;
      };
      const auto alternates = [&](bool first) {
        return has(0, first) && has(2, first) && has(1, !first) && has(3, !first);
      };
      may[highs] = may[highs] && (alternates(true) || alternates(false));
    }
  }
  return may;
}();

/// A crossed edge of each of the two contours that are the rims of one annulus.
struct Tunnel {
  EdgeIndex rim_a;
  EdgeIndex rim_b;
};

/// Cuts across z with columns A, B, C, D in cyclic order, whose signs alternate for lo < z < hi. In such a cut the
/// Highs are joined iff, as on a face, det(z) = AC - BD has the sign of A. det is quadratic; with its Bernstein
/// coefficients
///   g = det(0),  s = A0 C1 + A1 C0 - B0 D1 - B1 D0,  d = det(1),
/// it has two roots iff s s > 4 g d, on either side of (2g - s) / (2 (g + d - s)). Where a column ends the alternation
/// the resolution there is known: a High that ends leaves the Highs separated, a Low that ends leaves them joined; at a
/// face the face decider has spoken. If it is the same at both ends and different between two roots inside, two regions
/// that the cell's boundary separates meet inside: a tunnel. (Chernyaev 1995; the condition for every case, without his
/// errors: Custodio et al. 2013, Grosso 2016. The trilinear function has no more than two such events, hence one
/// tunnel.) A tie joins the Highs. `highs` and `joined_faces` are those of `value`. Exact for any finite values: where
/// the rounding of doubles might change an answer, integers of any length give it.
[[nodiscard]] std::optional<Tunnel> find_tunnel(const CellValues& value, CornerMask highs, FaceMask joined_faces);

}  // namespace scanknit
