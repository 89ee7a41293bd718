// Fills the parts of a texture that no triangle covers.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// Gives each uncovered pixel (0) the colour of a nearest covered one, so that filters and mipmaps show no seams. Does
/// nothing if no pixel is covered.
void fill_uncovered(const Image<std::uint8_t>& is_covered, ColourImage& image);

}  // namespace scanknit
