// Decodes a texture's picture, which may come from another program.
#pragma once

#include <cstddef>
#include <span>

#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// Decodes a PNG or JPEG file as sRGB; ignores transparency. Checks size and structure before it allocates three bytes
/// for each pixel. Errors (kInput): neither format, truncated, corrupt, or more than `limits.max_image_pixels`.
[[nodiscard]] Result<ColourImage> decode_texture(std::span<const std::byte> file, const Limits& limits);

}  // namespace scanknit
