// Finds the part of depth pictures that has depth, and crops frames to it.
#pragma once

#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/image.h"

namespace scanknit {

/// Pixels from (x0, y0) to (x1, y1), inclusive.
struct PixelRect {
  int x0, y0, x1, y1;
};

/// The rectangle in which any of the pictures, all of the same size, has depth, with a margin; nothing when none has.
[[nodiscard]] std::optional<PixelRect> rect_of(const std::vector<DepthImage>& pictures_m);

/// The median of all pixels with depth; 0 when there are none.
[[nodiscard]] double median_depth_m(const std::vector<DepthImage>& pictures_m);

/// Keeps only the depth pixels of `rect`, which must be within the picture, and what masks say of them. Colour has its
/// own camera and does not change.
void crop_frame(Frame& frame, const PixelRect& rect);

}  // namespace scanknit
