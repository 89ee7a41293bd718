// PNG pictures to pixels and back, by libpng.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/picture/png_structure.h"
#include "core/result.h"

namespace scanknit {

// Both decode what check_png let through. Errors (kInput): the compressed data are corrupt. All throw std::bad_alloc.

/// Grey as it is: T is of 8 or of 16 bits. `file.header` must be that of a grey picture of as many bits.
template <typename T>
[[nodiscard]] Result<Image<T>> decode_png_grey(const PngFile& file);

/// A PNG of any kind. Alpha is left out, and so is the lower byte of 16 bits.
[[nodiscard]] Result<ColourImage> decode_png_colour(const PngFile& file);

/// The alpha channel, without the lower byte of 16 bits. `file.header` must say that there is one.
[[nodiscard]] Result<Image<std::uint8_t>> decode_png_alpha(const PngFile& file);

enum class PngEffort {
  kFast,    ///< a third of the time of kSmall
  kMedium,  ///< for the many pictures of a recording
  kSmall,   ///< some fifth fewer bytes than kFast
};

// Errors (kOutput): no pixels, or a side of more than a million.

[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const Image<std::uint16_t>& image, PngEffort effort);
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image, PngEffort effort);

}  // namespace scanknit
