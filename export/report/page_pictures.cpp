#include "export/report/page_pictures.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/image.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "core/picture/png_structure.h"
#include "export/picture/with_opencv.h"
#include "export/report/page_text.h"

namespace scanknit {
namespace {

constexpr std::int64_t kMostSide = 8192;
constexpr int kJpegQuality = 85;

/// The pixels of `picture`, as OpenCV sees them.
cv::Mat matrix_of(ColourImage& picture) {
  return {picture.height(), picture.width(), CV_8UC3, picture.pixels().data()};
}

/// The same picture, `columns` wide.
ColourImage narrowed(ColourImage& picture, int columns) {
  ColourImage narrow(columns, std::max(1, picture.height() * columns / picture.width()));
  cv::Mat pixels = matrix_of(narrow);
  cv::resize(matrix_of(picture), pixels, pixels.size(), 0, 0, cv::INTER_AREA);
  return narrow;
}

}  // namespace

std::string picture_uri(std::span<const std::byte> png, int most_columns) {
  const auto file = check_png(png, Limits{.max_image_pixels = kMostSide * kMostSide});
  if (!file || file->header.width > kMostSide || file->header.height > kMostSide) return "";
  auto picture = decode_png_colour(*file);
  if (!picture) return "";
  if (picture->width() > most_columns) *picture = with_opencv([&] { return narrowed(*picture, most_columns); });
  const auto jpeg = encode_jpeg(*picture, kJpegQuality);
  return jpeg ? "data:image/jpeg;base64," + base64(std::as_bytes(std::span(*jpeg))) : "";
}

}  // namespace scanknit
