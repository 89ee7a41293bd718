#include "fusion/picture_part.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "core/median.h"

namespace scanknit {
namespace {

constexpr int kAround = 4;  // pixels

template <typename Picture>
Picture part_of(const Picture& picture, const PixelRect& rect) {
  Picture part(rect.x1 - rect.x0 + 1, rect.y1 - rect.y0 + 1, picture.at(rect.x0, rect.y0));
  for (int y = rect.y0; y <= rect.y1; ++y) {
    for (int x = rect.x0; x <= rect.x1; ++x) part.at(x - rect.x0, y - rect.y0) = picture.at(x, y);
  }
  return part;
}

}  // namespace

std::optional<PixelRect> rect_of(const std::vector<DepthImage>& pictures_m) {
  if (pictures_m.empty()) return std::nullopt;
  const int width = pictures_m.front().width();
  const int height = pictures_m.front().height();
  PixelRect rect{width, height, -1, -1};
  for (const DepthImage& picture : pictures_m) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        if (!(picture.at(x, y) > 0)) continue;
        rect = {std::min(rect.x0, x), std::min(rect.y0, y), std::max(rect.x1, x), std::max(rect.y1, y)};
      }
    }
  }
  if (rect.x1 < rect.x0) return std::nullopt;
  return PixelRect{std::max(0, rect.x0 - kAround), std::max(0, rect.y0 - kAround),
                   std::min(width - 1, rect.x1 + kAround), std::min(height - 1, rect.y1 + kAround)};
}

double median_depth_m(const std::vector<DepthImage>& pictures_m) {
  std::vector<float> depths;
  for (const DepthImage& picture : pictures_m) {
    std::copy_if(picture.pixels().begin(), picture.pixels().end(), std::back_inserter(depths),
                 [](float z) { return z > 0; });
  }
  return double{median(std::move(depths))};
}

void crop_frame(Frame& frame, const PixelRect& rect) {
  SCANKNIT_CHECK(frame.depth_m.contains(rect.x0, rect.y0) && frame.depth_m.contains(rect.x1, rect.y1));
  const auto crop = [&](auto& picture) {
    if (!picture.empty()) picture = part_of(picture, rect);
  };
  crop(frame.depth_m);
  crop(frame.normals);
  crop(frame.weights);
  crop(frame.outside_m);
  crop(frame.labels);
  frame.intrinsics.width = frame.depth_m.width();
  frame.intrinsics.height = frame.depth_m.height();
  frame.intrinsics.cx -= rect.x0;
  frame.intrinsics.cy -= rect.y0;
}

}  // namespace scanknit
