// JPEG pictures to pixels and back, by libjpeg.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/picture/jpeg_structure.h"
#include "core/result.h"

namespace scanknit {

/// What check_jpeg let through, with the header that it found. A baseline picture without Huffman tables has the
/// standard ones, as those of cameras do; damage to the entropy-coded data alone is not noticed. Errors (kInput):
/// corrupt. Both throw std::bad_alloc.
[[nodiscard]] Result<ColourImage> decode_jpeg(std::span<const std::byte> bytes, const JpegHeader& header);

/// Baseline, 4:2:0; `quality` 0 to 100. Errors (kOutput): no pixels, or a side of more than 65500.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality);

}  // namespace scanknit
