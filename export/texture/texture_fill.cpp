#include "export/texture/texture_fill.h"

#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/check.h"
#include "export/picture/with_opencv.h"

namespace scanknit {
namespace {

void fill_from_nearest(const Image<std::uint8_t>& is_covered, ColourImage& image) {
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

}  // namespace

void fill_uncovered(const Image<std::uint8_t>& is_covered, ColourImage& image) {
  SCANKNIT_CHECK(is_covered.width() == image.width() && is_covered.height() == image.height());
  if (image.empty()) return;
  with_opencv([&] { fill_from_nearest(is_covered, image); });
}

}  // namespace scanknit
