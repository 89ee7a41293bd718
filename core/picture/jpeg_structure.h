// Checks the structure of a JPEG file: its size, and that it is complete.
#pragma once

#include <cstddef>
#include <span>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct JpegHeader {
  int width = 0;
  int height = 0;
};

/// SOI and the first byte of another marker.
[[nodiscard]] bool looks_like_jpeg(std::span<const std::byte> bytes);

/// Walks the marker segments (ITU-T T.81, annex B) from SOI over a frame header to EOI, so that a file cut at any byte
/// is refused. Errors (kInput): not a JPEG, truncated, no frame header, dimensions of zero or beyond the limits.
[[nodiscard]] Result<JpegHeader> check_jpeg(std::span<const std::byte> bytes, const Limits& limits);

}  // namespace scanknit
