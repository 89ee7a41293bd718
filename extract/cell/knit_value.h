// The disambiguation value of "Knit High Above, Knit Low Below": how high can one walk between two corners of a cube?
#pragma once

#include <array>
#include <cstddef>

namespace scanknit {

/// The bottleneck between two corners of an N-cube: over all paths through the cube's multilinear interpolant, the
/// highest possible minimum along the path. The corners are joined in {value >= isovalue} iff isovalue <= this.
///
/// `corner_values`: finite, at most 1e38 in magnitude; corner = x + 2y + 4z + 8w. The result has their unit. It is
/// exact to rounding for N = 2 and 3, and never above the lower of the two corners. It depends on nothing but the
/// arguments: two cells that ask about the same cube, numbered alike, get the same bits.
/// N = 4 is in extract/reference/knit_value_4d.h.
///
/// D. B. Karron & J. Cox, Digital Morse Theory, 1999, definition 9: the rule for an ambiguous face takes the
/// maximum of this over the cubes that share the face.
template <int N>
[[nodiscard]] double knit_value(const std::array<double, std::size_t{1} << N>& corner_values, int corner_a,
                                int corner_b);

template <>
[[nodiscard]] double knit_value<2>(const std::array<double, 4>& corner_values, int corner_a, int corner_b);
template <>
[[nodiscard]] double knit_value<3>(const std::array<double, 8>& corner_values, int corner_a, int corner_b);

}  // namespace scanknit
