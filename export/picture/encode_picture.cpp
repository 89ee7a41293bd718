#include "export/picture/encode_picture.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace scanknit {
namespace {

Result<std::vector<std::uint8_t>> encode(const ColourImage& image, const char* format, const char* extension,
                                         const std::vector<int>& options) {
  if (image.empty()) return Error{ErrorCode::kOutput, "a picture without pixels cannot be written"};
  try {
    cv::Mat bgr(image.height(), image.width(), CV_8UC3);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const Rgb8 c = image.at(x, y);
        bgr.at<cv::Vec3b>(y, x) = {c.b, c.g, c.r};
      }
    }
    std::vector<std::uint8_t> bytes;
    if (cv::imencode(extension, bgr, bytes, options)) return bytes;
    return Error{ErrorCode::kOutput, fmt::format("the picture could not be encoded as {}", format)};
  } catch (const std::exception& problem) {  // cv::Exception, bad_alloc
    return Error{ErrorCode::kOutput, fmt::format("the picture could not be encoded as {}: {}", format, problem.what())};
  }
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image, PngEffort effort) {
  if (effort == PngEffort::kFast) return encode(image, "PNG", ".png", {});  // OpenCV's own choice
  return encode(image, "PNG", ".png", {cv::IMWRITE_PNG_COMPRESSION, 6});
}

Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality) {
  return encode(image, "JPEG", ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

}  // namespace scanknit
