// The parts of a texture that nothing covers.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// Gives each pixel that is not covered (0) the colour of a nearest one that is, so that filters and smaller versions
/// of the texture show no seams. Without any that is covered all stays as it is.
void fill_uncovered(const Image<std::uint8_t>& is_covered, ColourImage& image);

}  // namespace scanknit
