// A part of a frame's depth picture, as a smaller camera would have taken it.
#pragma once

#include <type_traits>

#include "core/check.h"
#include "core/frame.h"
#include "fusion/depth_pyramid.h"

namespace scanknit {

/// Keeps the depth pixels of `rect` (ends included, within the picture). Colour has its own camera and stays.
inline void crop_frame(Frame& frame, const PixelRect& rect) {
  const auto cropped = [&](const auto& image) {
    std::remove_cvref_t<decltype(image)> part(rect.x1 - rect.x0 + 1, rect.y1 - rect.y0 + 1, image.at(rect.x0, rect.y0));
    for (int y = rect.y0; y <= rect.y1; ++y) {
      for (int x = rect.x0; x <= rect.x1; ++x) part.at(x - rect.x0, y - rect.y0) = image.at(x, y);
    }
    return part;
  };
  SCANKNIT_CHECK(frame.depth_m.contains(rect.x0, rect.y0) && frame.depth_m.contains(rect.x1, rect.y1));
  frame.depth_m = cropped(frame.depth_m);
  if (!frame.normals.empty()) frame.normals = cropped(frame.normals);
  frame.intrinsics.width = frame.depth_m.width();
  frame.intrinsics.height = frame.depth_m.height();
  frame.intrinsics.cx -= rect.x0;
  frame.intrinsics.cy -= rect.y0;
}

}  // namespace scanknit
