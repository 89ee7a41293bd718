// Checks the structure of a PNG file before a library decodes it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct PngHeader {
  int width = 0;
  int height = 0;
  int bit_depth = 0;
  bool is_grey = false;    ///< one channel, no palette, no alpha
  bool has_alpha = false;  ///< a channel of it
};

/// Signature and IHDR only. Errors (kInput): not a PNG, dimensions of zero or beyond the limits.
[[nodiscard]] Result<PngHeader> read_png_header(std::span<const std::byte> bytes, const Limits& limits);

struct PngFile {
  PngHeader header;
  std::vector<std::byte> critical;  ///< the same picture with only its critical chunks
};

/// Walks every chunk up to IEND and checks lengths and CRCs (PNG specification 3rd ed., section 5), so that a file cut
/// at any byte is refused. `critical` has no ancillary chunks (colour profiles, text), because decoders warn about some
/// of them.
[[nodiscard]] Result<PngFile> check_png(std::span<const std::byte> bytes, const Limits& limits);

}  // namespace scanknit
