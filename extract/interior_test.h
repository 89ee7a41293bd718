// The interior test: does a tunnel join two contours of a cell?
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include "extract/cell.h"

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
/// tunnel.) A tie joins the Highs. `highs` and `joined_faces` are those of `value`.
[[nodiscard]] constexpr std::optional<Tunnel> find_tunnel(const CellValues& value, CornerMask highs,
                                                          FaceMask joined_faces) {
  constexpr auto kColumns = columns_along(2);
  constexpr int kUp = 4;
  constexpr std::size_t kNone = 4;
  struct End {
    double z;
    bool is_joined;
    std::size_t column = kNone;
  };
  const auto product = [&](std::size_t i, int up_i, std::size_t j, int up_j) {
    return value[static_cast<std::size_t>(kColumns[i] + up_i)] * value[static_cast<std::size_t>(kColumns[j] + up_j)];
  };
  const double g = product(0, 0, 2, 0) - product(1, 0, 3, 0);
  const double d = product(0, kUp, 2, kUp) - product(1, kUp, 3, kUp);
  const double s = (product(0, 0, 2, kUp) + product(0, kUp, 2, 0)) - (product(1, 0, 3, kUp) + product(1, kUp, 3, 0));
  const double curvature = g + d - s;
  const double turn = (2 * g - s) / (2 * curvature);
  if (!(s * s >= 4 * g * d) || !(0 < turn && turn < 1)) return std::nullopt;  // most cells; also where curvature is 0

  for (const std::size_t high_column : {std::size_t{0}, std::size_t{1}}) {
    // z = 0 and z = 1 stand for faces 4 and 5 until a column ends the alternation before.
    End lo{0, ((joined_faces >> 4) & 1) != 0};
    End hi{1, ((joined_faces >> 5) & 1) != 0};
    bool alternates = true;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool wants_high = i % 2 == high_column;
      const bool below = is_high(highs, kColumns[i]) == wants_high;
      const bool above = is_high(highs, kColumns[i] + kUp) == wants_high;
      alternates = alternates && (below || above);
      if (below == above) continue;
      const double at_0 = value[static_cast<std::size_t>(kColumns[i])];
      const double at_1 = value[static_cast<std::size_t>(kColumns[i] + kUp)];
      const End end{at_0 / (at_0 - at_1), !wants_high, i};
      End& limit = above ? lo : hi;
      const bool is_tighter = above ? end.z > limit.z : end.z < limit.z;
      const bool is_tie = end.z == limit.z && end.is_joined;
      if (limit.column == kNone || is_tighter || is_tie) limit = end;
    }
    if (!alternates || !(lo.z < hi.z) || lo.is_joined != hi.is_joined) continue;

    const bool opens_towards_joined = (curvature > 0) == (high_column == 0);  // det > 0 joins columns 0 and 2
    const bool is_tangent = s * s == 4 * g * d;  // it reaches zero, which joins the Highs but not the Lows
    if (opens_towards_joined != lo.is_joined || (lo.is_joined && is_tangent)) continue;
    if (!(lo.z < turn && turn < hi.z)) continue;

    if (lo.column != kNone && hi.column != kNone) {  // one rim passes through each of the two columns that end
      return Tunnel{static_cast<EdgeIndex>(edge_between(kColumns[lo.column], kColumns[lo.column] + kUp)),
                    static_cast<EdgeIndex>(edge_between(kColumns[hi.column], kColumns[hi.column] + kUp))};
    }
    const int up = lo.column == kNone ? 0 : kUp;  // the face shows a segment of each rim
    return Tunnel{static_cast<EdgeIndex>(edge_between(kColumns[0] + up, kColumns[1] + up)),
                  static_cast<EdgeIndex>(edge_between(kColumns[2] + up, kColumns[3] + up))};
  }
  return std::nullopt;
}

}  // namespace scanknit
