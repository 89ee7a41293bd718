// The parts of a texture that nothing covers, and the file it becomes.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// Gives each pixel that is not covered (0) the colour of a nearest one that is, so that filters and smaller versions
/// of the texture show no seams. Without any that is covered all stays as it is.
void fill_uncovered(const Image<std::uint8_t>& is_covered, ColourImage& image);

/// Errors: kOutput for what the library cannot encode.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image);
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality = 92);

}  // namespace scanknit
