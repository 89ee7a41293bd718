#include "export/picture/depth_picture.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/picture/jpeg_codec.h"
#include "export/picture/with_opencv.h"

namespace scanknit {
namespace {

ColourImage coloured(const DepthImage& depth_m) {
  constexpr int kMostWidth = 320;
  const int step = (depth_m.width() + kMostWidth - 1) / kMostWidth;
  cv::Mat small(depth_m.height() / step, depth_m.width() / step, CV_32F);
  std::vector<float> seen;
  for (int y = 0; y < small.rows; ++y) {
    const auto row = depth_m.row(y * step);
    for (int x = 0; x < small.cols; ++x) {
      const float depth = row[static_cast<std::size_t>(x * step)];
      small.at<float>(y, x) = depth;
      if (depth > 0) seen.push_back(depth);
    }
  }
  float near = 0;
  float far = 1;
  if (!seen.empty()) {  // but for the outermost twentieths
    const auto at = [&](std::size_t twentieth) {
      const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(twentieth * (seen.size() - 1) / 20);
      std::nth_element(seen.begin(), middle, seen.end());
      return *middle;
    };
    near = at(1);
    far = std::max(at(19), near + 1e-3f);
  }
  cv::Mat grey;
  small.convertTo(grey, CV_8U, -255.0 / static_cast<double>(far - near),
                  255.0 * static_cast<double>(far / (far - near)));
  cv::Mat colours;
  cv::applyColorMap(grey, colours, cv::COLORMAP_TURBO);
  colours.setTo(cv::Scalar(0, 0, 0), small <= 0);
  ColourImage picture(colours.cols, colours.rows);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const auto& bgr = colours.at<cv::Vec3b>(y, x);
      picture.at(x, y) = {bgr[2], bgr[1], bgr[0]};
    }
  }
  return picture;
}

}  // namespace

std::vector<std::uint8_t> depth_picture(const DepthImage& depth_m) {
  constexpr int kJpegQuality = 80;
  if (depth_m.empty()) return {};
  auto jpeg = encode_jpeg(with_opencv([&] { return coloured(depth_m); }), kJpegQuality);
  return jpeg ? *std::move(jpeg) : std::vector<std::uint8_t>();
}

}  // namespace scanknit
