// A colour picture from the bytes of a file of either kind.
#pragma once

#include <cstddef>
#include <span>

#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// A PNG or JPEG of any kind; alpha is left out, an orientation tag is ignored. Size and structure are checked
/// before any memory is asked for, which is three bytes a pixel. Errors (kInput, without `where`): neither of the two,
/// cut short, corrupt, of more than `limits.max_image_pixels`.
[[nodiscard]] Result<ColourImage> decode_picture(std::span<const std::byte> bytes, const Limits& limits);

}  // namespace scanknit
