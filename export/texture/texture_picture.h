// The picture of a texture that somebody else may have written.
#pragma once

#include <cstddef>
#include <span>

#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// A PNG or JPEG file, as sRGB; what is transparent has its colour all the same. Size and structure are checked before
/// any memory is asked for, which is three bytes a pixel. Errors (kInput): neither of the two, cut short, corrupt, of
/// more than `limits.max_image_pixels`.
[[nodiscard]] Result<ColourImage> decode_texture(std::span<const std::byte> file, const Limits& limits);

}  // namespace scanknit
