#include "export/picture/colour_scale.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "export/picture/rasteriser.h"
#include "export/picture/with_opencv.h"

namespace scanknit {
namespace {

constexpr int kScaleHeight = 84, kBarTop = 10, kBarHeight = 18, kLabelBase = 46, kTitleBase = 72;
constexpr double kScaleMargin = 0.08;  // of the width, on either side
constexpr double kScaleTextSize = 0.5;

/// Centred at `x`, but within the picture.
void draw_scale_text(cv::Mat& canvas, const std::string& text, double x, int base) {
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kScaleTextSize, 1, &below);
  const int left =
      std::clamp(static_cast<int>(std::lround(x)) - size.width / 2, 0, std::max(0, canvas.cols - size.width));
  cv::putText(canvas, text, {left, base}, cv::FONT_HERSHEY_SIMPLEX, kScaleTextSize, cv::Scalar(40, 40, 40), 1,
              cv::LINE_AA);
}

ColourImage drawn_colour_scale(const ColourImage& picture, std::span<const Rgb8> colours,
                               const std::vector<ScaleLabel>& labels, const std::string& title) {
  const int width = picture.width();
  ColourImage whole(width, picture.height() + kScaleHeight, kBackground);
  for (int y = 0; y < picture.height(); ++y)
    std::copy(picture.row(y).begin(), picture.row(y).end(), whole.row(y).begin());
  const int left = static_cast<int>(kScaleMargin * width), bar_width = std::max(1, width - 2 * left);
  for (int y = 0; y < kBarHeight; ++y) {
    for (int x = 0; x < bar_width; ++x) {
      const auto place = static_cast<std::size_t>(x) * colours.size() / static_cast<std::size_t>(bar_width);
      whole.at(left + x, picture.height() + kBarTop + y) = colours[place];
    }
  }
  cv::Mat strip(kScaleHeight, width, CV_8UC3, cv::Scalar(0, 0, 0));
  for (int y = 0; y < kScaleHeight; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb8 pixel = whole.at(x, picture.height() + y);
      strip.at<cv::Vec3b>(y, x) = {pixel.r, pixel.g, pixel.b};
    }
  }
  for (const ScaleLabel& label : labels) draw_scale_text(strip, label.text, left + label.place * bar_width, kLabelBase);
  draw_scale_text(strip, title, width / 2.0, kTitleBase);
  for (int y = 0; y < kScaleHeight; ++y) {
    for (int x = 0; x < width; ++x) {
      const cv::Vec3b pixel = strip.at<cv::Vec3b>(y, x);
      whole.at(x, picture.height() + y) = {pixel[0], pixel[1], pixel[2]};
    }
  }
  return whole;
}

}  // namespace

ColourImage with_colour_scale(const ColourImage& picture, std::span<const Rgb8> colours,
                              const std::vector<ScaleLabel>& labels, const std::string& title) {
  SCANKNIT_CHECK(!colours.empty());
  return with_opencv([&] { return drawn_colour_scale(picture, colours, labels, title); });
}

}  // namespace scanknit
