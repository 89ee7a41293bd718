// A part of a depth picture: where there is something in it, and the frame that a smaller camera would have taken.
#pragma once

#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/image.h"

namespace scanknit {

/// Pixels from (x0, y0) to (x1, y1), both included.
struct PixelRect {
  int x0, y0, x1, y1;
};

/// Where any of the pictures, all of one size, has depth, and a little around; nothing when none has.
[[nodiscard]] std::optional<PixelRect> rect_of(const std::vector<DepthImage>& pictures_m);

/// Of all pixels that have depth; 0 when none has.
[[nodiscard]] double median_depth_m(const std::vector<DepthImage>& pictures_m);

/// Keeps the depth pixels of `rect`, which lies within the picture. Colour has its own camera and stays.
void crop_frame(Frame& frame, const PixelRect& rect);

}  // namespace scanknit
