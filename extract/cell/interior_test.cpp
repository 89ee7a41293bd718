#include "extract/cell/interior_test.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

namespace scanknit {
namespace {

using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;

/// The search for a tunnel in numbers of any kind. All that decides is a sign.
template <typename Number, typename Sign>
class TunnelSearch {
 public:
  TunnelSearch(const std::array<Number, kCorners>& value, CornerMask highs, FaceMask joined_faces, Sign& sign)
      : value_(value), highs_(highs), joined_faces_(joined_faces), sign_(sign) {}

  std::optional<Tunnel> find() {
    const Number g = product(0, 0, 2, 0) - product(1, 0, 3, 0);
    const Number d = product(0, kUp, 2, kUp) - product(1, kUp, 3, kUp);
    const Number s = (product(0, 0, 2, kUp) + product(0, kUp, 2, 0)) - (product(1, 0, 3, kUp) + product(1, kUp, 3, 0));
    const Number curvature = g + d - s;
    const int bend = sign_(curvature);
    if (bend == 0) return std::nullopt;
    const auto positive = [&](const Number& x) { return bend > 0 ? x : -x; };
    const Fraction turn{positive(g + g - s), positive(curvature + curvature)};
    if (!(sign_(turn.above) > 0) || !(sign_(turn.below - turn.above) > 0)) return std::nullopt;  // most cells
    const int discriminant = sign_(s * s - Number(4) * g * d);
    if (discriminant < 0) return std::nullopt;

    for (const std::size_t high_column : {std::size_t{0}, std::size_t{1}}) {
      const std::optional<Stretch> stretch = alternating(high_column);
      if (!stretch || !is_before(stretch->lo.z, stretch->hi.z)) continue;
      const auto& [lo, hi] = *stretch;
      if (lo.is_joined != hi.is_joined) continue;
      const bool opens_towards_joined = (bend > 0) == (high_column == 0);  // det > 0 joins columns 0 and 2
      const bool is_tangent = discriminant == 0;  // it reaches zero, which joins the Highs but not the Lows
      if (opens_towards_joined != lo.is_joined || (lo.is_joined && is_tangent)) continue;
      if (is_before(lo.z, turn) && is_before(turn, hi.z)) return tunnel_between(lo.column, hi.column);
    }
    return std::nullopt;
  }

 private:
  static constexpr auto kColumns = columns_along(2);
  static constexpr int kUp = 4;
  static constexpr std::size_t kNone = 4;

  struct Fraction {
    Number above, below;  ///< below > 0
  };
  struct End {
    Fraction z;
    bool is_joined;
    std::size_t column = kNone;  ///< that ends the alternation; none: the cell's face does
  };
  struct Stretch {
    End lo, hi;
  };

  [[nodiscard]] Number product(std::size_t i, int up_i, std::size_t j, int up_j) const {
    return value_[static_cast<std::size_t>(kColumns[i] + up_i)] * value_[static_cast<std::size_t>(kColumns[j] + up_j)];
  }

  [[nodiscard]] int compare(const Fraction& a, const Fraction& b) {
    return sign_(a.above * b.below - b.above * a.below);
  }
  [[nodiscard]] bool is_before(const Fraction& a, const Fraction& b) { return compare(a, b) < 0; }

  /// The cuts in which column `high_column` and its opposite are High and the other two Low.
  [[nodiscard]] std::optional<Stretch> alternating(std::size_t high_column) {
    Stretch stretch{{{Number(0), Number(1)}, ((joined_faces_ >> 4) & 1) != 0},
                    {{Number(1), Number(1)}, ((joined_faces_ >> 5) & 1) != 0}};
    for (std::size_t i = 0; i < 4; ++i) {
      const bool wants_high = i % 2 == high_column;
      const bool below = is_high(highs_, kColumns[i]) == wants_high;
      const bool above = is_high(highs_, kColumns[i] + kUp) == wants_high;
      if (!below && !above) return std::nullopt;
      if (below && above) continue;
      const Number& at_0 = value_[static_cast<std::size_t>(kColumns[i])];
      const Number& at_1 = value_[static_cast<std::size_t>(kColumns[i] + kUp)];
      const bool begins_high = is_high(highs_, kColumns[i]);
      const End end{begins_high ? Fraction{at_0, at_0 - at_1} : Fraction{-at_0, at_1 - at_0}, !wants_high, i};
      End& limit = above ? stretch.lo : stretch.hi;
      const int order = limit.column == kNone ? 0 : compare(end.z, limit.z);
      const bool is_tighter = above ? order > 0 : order < 0;
      if (limit.column == kNone || is_tighter || (order == 0 && end.is_joined)) limit = end;
    }
    return stretch;
  }

  [[nodiscard]] static Tunnel tunnel_between(std::size_t lo, std::size_t hi) {
    if (lo != kNone && hi != kNone)  // one rim passes through each of the two columns that end
      return {static_cast<EdgeIndex>(edge_between(kColumns[lo], kColumns[lo] + kUp)),
              static_cast<EdgeIndex>(edge_between(kColumns[hi], kColumns[hi] + kUp))};
    const int up = lo == kNone ? 0 : kUp;  // the face shows a segment of each rim
    return {static_cast<EdgeIndex>(edge_between(kColumns[0] + up, kColumns[1] + up)),
            static_cast<EdgeIndex>(edge_between(kColumns[2] + up, kColumns[3] + up))};
  }

  const std::array<Number, kCorners>& value_;
  CornerMask highs_;
  FaceMask joined_faces_;
  Sign& sign_;
};

/// The values times one power of two.
std::array<Integer, kCorners> integers_of(const CellValues& value) {
  constexpr int kDigits = std::numeric_limits<double>::digits;
  int least = std::numeric_limits<int>::max();
  std::array<std::int64_t, kCorners> digits{};
  std::array<int, kCorners> exponents{};
  for (std::size_t i = 0; i < kCorners; ++i) {
    digits[i] = static_cast<std::int64_t>(std::ldexp(std::frexp(value[i], &exponents[i]), kDigits));
    if (digits[i] != 0) least = std::min(least, exponents[i]);
  }
  std::array<Integer, kCorners> integers;
  for (std::size_t i = 0; i < kCorners; ++i) {
    integers[i] = digits[i];
    if (digits[i] != 0) integers[i] <<= exponents[i] - least;
  }
  return integers;
}

/// True where the quadratic surely has no turn in the cell, or no root: most cells, by a tenth of the work. All that is
/// computed here is off by less than 2^-45 of the largest value squared, the discriminant by 2^-44 of its fourth power.
bool has_surely_no_tunnel(const CellValues& v, double largest) {
  const double g = v[0] * v[3] - v[1] * v[2];
  const double d = v[4] * v[7] - v[5] * v[6];
  const double s = (v[0] * v[7] + v[4] * v[3]) - (v[1] * v[6] + v[5] * v[2]);
  const double squared = largest * largest;
  const double margin = 0x1p-45 * squared;
  const double curvature = g + d - s;
  const double turn = curvature > 0 ? g + g - s : s - g - g;  // in units of 2 |curvature|
  const bool is_bent = std::abs(curvature) > margin;
  const bool turns_outside = turn < -margin || turn > 2 * std::abs(curvature) + 4 * margin;
  return (is_bent && turns_outside) || s * s - 4 * g * d < -0x1p-44 * squared * squared;
}

/// -1, 0 or 1; 0 and a note of it where rounding might have made another sign.
class RoundedSign {
 public:
  /// For values below 2 in magnitude: then all that the search computes is below 2^9, by some dozens of operations, and
  /// off by less than this.
  static constexpr double kMargin = 0x1p-36;

  int operator()(double x) {
    if (std::abs(x) > kMargin) return x > 0 ? 1 : -1;
    is_in_doubt_ = true;
    return 0;
  }
  [[nodiscard]] bool is_in_doubt() const { return is_in_doubt_; }

 private:
  bool is_in_doubt_ = false;
};

/// The values times the power of two that brings the largest magnitude to between 1 and 2. Exact.
CellValues scaled_to_one(const CellValues& value, double largest) {
  if (!(largest > 0)) return value;
  const double scale = std::ldexp(1.0, -std::ilogb(largest));
  CellValues scaled;
  std::transform(value.begin(), value.end(), scaled.begin(), [&](double v) { return v * scale; });
  return scaled;
}

}  // namespace

std::optional<Tunnel> find_tunnel(const CellValues& value, CornerMask highs, FaceMask joined_faces) {
  double largest = 0;
  for (const double v : value) largest = std::max(largest, std::abs(v));
  if (has_surely_no_tunnel(value, largest)) return std::nullopt;

  RoundedSign sign;
  const auto tunnel = TunnelSearch(scaled_to_one(value, largest), highs, joined_faces, sign).find();
  if (!sign.is_in_doubt()) return tunnel;

  const auto exact_sign = [](const Integer& x) { return x.sign(); };
  return TunnelSearch(integers_of(value), highs, joined_faces, exact_sign).find();
}

}  // namespace scanknit
