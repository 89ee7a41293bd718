// The face deciders: are the two Highs of an ambiguous face joined, or the two Lows?
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace scanknit {

enum class FaceDecision : std::uint8_t { kUnambiguous, kHighsSeparated, kHighsJoined };

/// A face's corners in the order of kFaceRing, (0,0) (1,0) (1,1) (0,1), each minus the isovalue; >= 0 is High.
using FaceValues = std::array<double, 4>;

[[nodiscard]] constexpr bool is_ambiguous(const FaceValues& value) {
  const bool first_is_high = value[0] >= 0;
  return (value[2] >= 0) == first_is_high && (value[1] >= 0) != first_is_high && (value[3] >= 0) != first_is_high;
}

/// Nielson & Hamann 1991: the Highs are joined iff the saddle of the bilinear interpolant is High. With B in {s, t},
///   saddle = (B00 B11 - B10 B01) / (B00 + B11 - B01 - B10).
/// (The lecture that this project follows prints a plus in the numerator; B00 = B11 = 1, B01 = B10 = -1 is the
/// function (1 - 2s)(1 - 2t), whose saddle value is 0 and not 1/2: it is a minus.)
/// On an ambiguous face the denominator has the sign of the diagonal B00, B11. So, whichever diagonal is High,
///   saddle >= 0  <=>  product of the Highs >= product of the Lows,
/// without a division. A product of two doubles does not depend on their order, nor does the comparison on where the
/// corners are counted from: both cells that share the face decide the same, bit for bit. Rounding keeps the order of
/// products or makes them equal; then what was rounded off decides. A tie joins the Highs.
[[nodiscard]] inline FaceDecision decide_face(const FaceValues& value) {
  if (!is_ambiguous(value)) return FaceDecision::kUnambiguous;
  double even = value[0] * value[2];
  double odd = value[1] * value[3];
  if (even == odd) {
    even = std::fma(value[0], value[2], -even);
    odd = std::fma(value[1], value[3], -odd);
  }
  const bool joined = value[0] >= 0 ? even >= odd : odd >= even;
  return joined ? FaceDecision::kHighsJoined : FaceDecision::kHighsSeparated;
}

/// The chord decider (the Chinese report among the project's seeds): join the surface's points on opposite edges; the
/// interpolant's sign where the two chords cross decides. Along a chord the interpolant is quadratic and vanishes at
/// both ends; so it has one sign between them, the saddle's, and the two deciders agree in every strict case. A value
/// within rounding of zero tells nothing; there the products decide, so that a tie joins the Highs.
[[nodiscard]] inline FaceDecision decide_face_by_chord(const FaceValues& value) {
  if (!is_ambiguous(value)) return FaceDecision::kUnambiguous;
  const auto [a, b, c, d] = value;
  const double s0 = a / (a - b);  // on the edge t = 0
  const double s1 = d / (d - c);  // t = 1
  const double t0 = a / (a - d);  // s = 0
  const double t1 = b / (b - c);  // s = 1
  // s = s0 + (s1 - s0) t and t = t0 + (t1 - t0) s; each slope is within (-1, 1) unless points lie on corners.
  const double determinant = 1 - (s1 - s0) * (t1 - t0);
  if (!(determinant > 0)) return decide_face(value);
  const double s = (s0 + (s1 - s0) * t0) / determinant;
  const double t = t0 + (t1 - t0) * s;
  const double at_crossing = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * d + s * c);
  constexpr double kRounding = 0x1p-48;  // some twenty operations of 2^-53 each
  const double scale = std::abs(a) + std::abs(b) + std::abs(c) + std::abs(d);
  // Near a determinant of 0 the crossing itself is rounded by as much as that magnifies.
  if (std::abs(at_crossing) * determinant <= kRounding * scale) return decide_face(value);
  return at_crossing > 0 ? FaceDecision::kHighsJoined : FaceDecision::kHighsSeparated;
}

}  // namespace scanknit
