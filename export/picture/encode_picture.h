// Pictures as the bytes of a file.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace scanknit {

enum class PngEffort {
  kFast,   ///< a third of the time
  kSmall,  ///< some fifth fewer bytes
};

/// Errors: kOutput for a picture without pixels, and what the library cannot encode.
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image, PngEffort effort);
[[nodiscard]] Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality);

}  // namespace scanknit
