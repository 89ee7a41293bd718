// What the scanner sees, as a small picture.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace scanknit {

/// Depth in colours (near: red, far: blue; black: no return), scaled to the range of this picture, at most 320 pixels
/// wide, as a JPEG file; empty for a picture without depth.
[[nodiscard]] std::vector<std::uint8_t> depth_picture(const DepthImage& depth_m);

}  // namespace scanknit
