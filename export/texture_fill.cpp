#include "export/texture_fill.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/check.h"

namespace scanknit {
namespace {

Result<std::vector<std::uint8_t>> encode(const ColourImage& image, const char* extension,
                                         const std::vector<int>& options) {
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
    return Error{ErrorCode::kOutput, "the texture could not be encoded"};
  } catch (const std::exception& problem) {
    return Error{ErrorCode::kOutput, std::string("the texture could not be encoded: ") + problem.what()};
  }
}

}  // namespace

void fill_uncovered(const Image<std::uint8_t>& is_covered, ColourImage& image) {
  SCANKNIT_CHECK(is_covered.width() == image.width() && is_covered.height() == image.height());
  if (image.empty()) return;
  cv::Mat is_empty(image.height(), image.width(), CV_8U), distance, nearest;
  std::size_t covered = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const bool is_here = is_covered.at(x, y) != 0;
      is_empty.at<std::uint8_t>(y, x) = is_here ? 0 : 1;
      covered += is_here ? 1 : 0;
    }
  }
  if (covered == 0 || covered == image.size()) return;
  cv::distanceTransform(is_empty, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<Rgb8> colour_of(covered + 1);  // labels count from 1
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (is_covered.at(x, y) != 0) colour_of[static_cast<std::size_t>(nearest.at<int>(y, x))] = image.at(x, y);
    }
  }
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (is_covered.at(x, y) == 0) image.at(x, y) = colour_of[static_cast<std::size_t>(nearest.at<int>(y, x))];
    }
  }
}

Result<std::vector<std::uint8_t>> encode_png(const ColourImage& image) {
  return encode(image, ".png", {cv::IMWRITE_PNG_COMPRESSION, 6});
}

Result<std::vector<std::uint8_t>> encode_jpeg(const ColourImage& image, int quality) {
  return encode(image, ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

}  // namespace scanknit
