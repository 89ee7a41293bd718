// Which corners of a cube are connected at or above a level, through the interior of its trilinear interpolant?
#pragma once

#include <array>
#include <cstdint>

namespace scanknit {

inline constexpr std::int8_t kBelowLevel = -1;

/// For each corner (numbered as in cell.h) the label of its component of {trilinear >= level}, or kBelowLevel. Two
/// corners have the same label iff a path joins them; labels have no other meaning. `corner_values` and `level` are
/// finite and at most 1e38 in magnitude.
///
/// A sweep over slices: every component of a bilinear slice holds a corner of it, hence four corners and one diagonal
/// describe a slice. They change only where a corner of the slice crosses the level or, the slice alternating, where
/// its face saddle does (Nielson & Hamann 1991): at the roots of four linear polynomials and a quadratic one.
[[nodiscard]] std::array<std::int8_t, 8> superlevel_components(const std::array<double, 8>& corner_values,
                                                               double level);

}  // namespace scanknit
