#include "extract/cell/knit_value.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "extract/cell/superlevel_components.h"

namespace scanknit {
namespace {

/// Between the opposite corners a and b of a square whose other corners are m and n: round the higher of these, or over
/// the face saddle (a b - m n) / (a + b - m - n), here relative to that corner, where nothing cancels.
double across_square(double a, double b, double m, double n) {
  const double lower = std::min(a, b);
  const double detour = std::max(m, n);
  if (detour >= lower) return lower;
  const double p = a - detour;
  const double q = b - detour;
  const double saddle = detour + p * q / ((p + q) + (detour - std::min(m, n)));
  return std::min(saddle, lower);
}

/// Between two corners of an edge or the diagonal of a face.
double along_boundary(const std::array<double, 8>& v, unsigned a, unsigned b) {
  const unsigned across = a ^ b;
  if (std::has_single_bit(across)) return std::min(v[a], v[b]);
  const unsigned step = across & (~across + 1);  // the lower of its two bits
  return across_square(v[a], v[b], v[a ^ step], v[b ^ step]);
}

/// The bottleneck among paths in the cube's boundary: Dijkstra's algorithm over edges and face diagonals.
double widest_boundary_path(const std::array<double, 8>& v, unsigned a, unsigned b) {
  std::array<double, 8> width{};
  width.fill(-std::numeric_limits<double>::infinity());
  width[a] = v[a];
  for (unsigned open = 0xff; ((open >> b) & 1) != 0;) {
    unsigned next = b;
    for (unsigned i = 0; i < 8; ++i) {
      if (((open >> i) & 1) != 0 && width[i] > width[next]) next = i;
    }
    open &= ~(1u << next);
    for (unsigned i = 0; i < 8; ++i) {
      if (((open >> i) & 1) != 0 && std::popcount(next ^ i) < 3)
        width[i] = std::max(width[i], std::min(width[next], along_boundary(v, next, i)));
    }
  }
  return width[b];
}

/// The saddle value of the slice at height z of a cube, z not where the slice is linear. Relative to the slice's mean,
/// from which a saddle inside the slice is no further than the denominator is large: nothing is lost to cancellation.
double slice_saddle(const std::array<double, 8>& v, double z) {
  std::array<double, 4> s{};
  for (std::size_t c = 0; c < 4; ++c) s[c] = (1 - z) * v[c] + z * v[c + 4];
  const double mean = ((s[0] + s[3]) + (s[1] + s[2])) / 4;
  const double curvature = (s[0] + s[3]) - (s[1] + s[2]);
  return mean + ((s[0] - mean) * (s[3] - mean) - (s[1] - mean) * (s[2] - mean)) / curvature;
}

/// The values of the cube's body saddles, not a number where there is none. The trilinear function is stationary where
/// its slices' saddle value det / S is: with the columns A, B, D, C = x + 2y, each v0 + slope z, at the roots of
/// det' S - det S' = d2 s1 z^2 + 2 d2 s0 z + (d1 s0 - d0 s1). A cube whose slices have no isolated stationary point is
/// stationary along a curve, which leaves through a face: the boundary knows its value.
std::array<double, 2> body_saddles(std::array<double, 8> v) {
  const double reference = v[0];
  for (double& value : v) value -= reference;
  std::array<double, 4> slope{};
  for (std::size_t c = 0; c < 4; ++c) slope[c] = v[c + 4] - v[c];
  const double d0 = v[0] * v[3] - v[1] * v[2];
  const double d1 = (v[0] * slope[3] + slope[0] * v[3]) - (v[1] * slope[2] + slope[1] * v[2]);
  const double d2 = slope[0] * slope[3] - slope[1] * slope[2];
  const double s0 = (v[0] + v[3]) - (v[1] + v[2]);
  const double s1 = (slope[0] + slope[3]) - (slope[1] + slope[2]);

  const double quadratic = d2 * s1;
  const double half_linear = d2 * s0;
  const double constant = d1 * s0 - d0 * s1;
  // A negative discriminant or a vanishing coefficient gives NaN or infinity, which are not between 0 and 1.
  const double q =
      -(half_linear + std::copysign(std::sqrt(half_linear * half_linear - quadratic * constant), half_linear));
  const auto value_at = [&](double z) {
    return z > 0 && z < 1 ? reference + slice_saddle(v, z) : std::numeric_limits<double>::quiet_NaN();
  };
  return {value_at(q / quadratic), value_at(constant / q)};
}

bool are_joined(const std::array<double, 8>& v, unsigned a, unsigned b, double level) {
  const auto component = superlevel_components(v, level);
  return component[a] != kBelowLevel && component[a] == component[b];
}

bool is_corner(int corner, int corners) {
  return corner >= 0 && corner < corners;
}

}  // namespace

template <>
double knit_value<2>(const std::array<double, 4>& corner_values, int corner_a, int corner_b) {
  SCANKNIT_CHECK(is_corner(corner_a, 4) && is_corner(corner_b, 4));
  const auto a = static_cast<unsigned>(corner_a);
  const auto b = static_cast<unsigned>(corner_b);
  const auto& v = corner_values;
  return (a ^ b) == 3 ? across_square(v[a], v[b], v[a ^ 1], v[b ^ 1]) : std::min(v[a], v[b]);
}

template <>
double knit_value<3>(const std::array<double, 8>& corner_values, int corner_a, int corner_b) {
  SCANKNIT_CHECK(is_corner(corner_a, 8) && is_corner(corner_b, 8));
  const auto a = static_cast<unsigned>(corner_a);
  const auto b = static_cast<unsigned>(corner_b);
  const double lower = widest_boundary_path(corner_values, a, b);
  const double upper = std::min(corner_values[a], corner_values[b]);
  if (lower >= upper) return upper;

  // As the level falls, components meet at a face saddle, which the boundary knows, or at a body saddle (Morse theory):
  // the answer iff the corners are joined just above the next lower candidate.
  auto [first, second] = body_saddles(corner_values);
  first = first > lower ? std::min(first, upper) : lower;
  second = second > lower ? std::min(second, upper) : lower;
  const double low = std::min(first, second);
  const double high = std::max(first, second);
  if (low < high && are_joined(corner_values, a, b, low + (high - low) / 2)) return high;
  if (lower < low && are_joined(corner_values, a, b, lower + (low - lower) / 2)) return low;
  return lower;
}

}  // namespace scanknit
