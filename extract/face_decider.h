// The asymptotic decider: are the two Highs of an ambiguous face joined, or the two Lows?
#pragma once

#include <array>
#include <cstdint>

namespace scanknit {

enum class FaceDecision : std::uint8_t { kUnambiguous, kHighsSeparated, kHighsJoined };

/// `value` holds the face's corners in cyclic order, each minus the isovalue; >= 0 is High.
///
/// Nielson & Hamann 1991: the Highs are joined iff the saddle of the bilinear interpolant is High. With B in {s, t},
///   saddle = (B00 B11 - B10 B01) / (B00 + B11 - B01 - B10).
/// (The lecture that this project follows prints a plus in the numerator; B00 = B11 = 1, B01 = B10 = -1 is the
/// function (1 - 2s)(1 - 2t), whose saddle value is 0 and not 1/2: it is a minus.)
/// On an ambiguous face the denominator has the sign of the diagonal B00, B11. So, whichever diagonal is High,
///   saddle >= 0  <=>  product of the Highs >= product of the Lows,
/// without a division. A product of two doubles does not depend on their order, nor does the comparison on where the
/// corners are counted from: both cells that share the face decide the same, bit for bit. A tie joins the Highs.
[[nodiscard]] constexpr FaceDecision decide_face(const std::array<double, 4>& value) {
  const bool first_is_high = value[0] >= 0;
  const bool is_ambiguous =
      (value[2] >= 0) == first_is_high && (value[1] >= 0) != first_is_high && (value[3] >= 0) != first_is_high;
  if (!is_ambiguous) return FaceDecision::kUnambiguous;
  const double even = value[0] * value[2];
  const double odd = value[1] * value[3];
  const bool joined = first_is_high ? even >= odd : odd >= even;
  return joined ? FaceDecision::kHighsJoined : FaceDecision::kHighsSeparated;
}

}  // namespace scanknit
