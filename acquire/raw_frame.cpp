#include "acquire/raw_frame.h"

namespace scanknit {

const char* to_string(PixelFormat format) {
  switch (format) {
    case PixelFormat::kZ16: return "z16";
    case PixelFormat::kYuyv: return "yuyv";
    case PixelFormat::kUyvy: return "uyvy";
    case PixelFormat::kMjpeg: return "mjpeg";
    case PixelFormat::kRgb8: return "rgb8";
    case PixelFormat::kBgr8: return "bgr8";
  }
  return "unknown";
}

}  // namespace scanknit
