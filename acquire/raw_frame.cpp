#include "acquire/raw_frame.h"

#include <algorithm>

namespace scanknit {

const char* to_string(PixelFormat format) {
  switch (format) {
    case PixelFormat::kZ16: return "z16";
    case PixelFormat::kYuyv: return "yuyv";
    case PixelFormat::kUyvy: return "uyvy";
    case PixelFormat::kMjpeg: return "mjpeg";
    case PixelFormat::kRgb8: return "rgb8";
    case PixelFormat::kBgr8: return "bgr8";
    case PixelFormat::kY8i: return "y8i";
  }
  return "unknown";
}

void mirror(std::vector<std::byte>& pixels, std::size_t width, std::size_t pixel_bytes) {
  const std::size_t row_bytes = width * pixel_bytes;
  for (std::size_t row = 0; row + row_bytes <= pixels.size(); row += row_bytes) {
    const auto at = [&](std::size_t x) { return pixels.begin() + static_cast<std::ptrdiff_t>(row + x * pixel_bytes); };
    for (std::size_t left = 0, right = width - 1; left < right; ++left, --right) {
      std::swap_ranges(at(left), at(left + 1), at(right));
    }
  }
}

}  // namespace scanknit
