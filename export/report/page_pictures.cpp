#include "export/report/page_pictures.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "export/report/page_text.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kMostSide = 8192;
constexpr int kJpegQuality = 85;

/// PNG, 5.2 and 11.2.2: the signature, then the header with its width and height, big-endian.
bool is_png_of_sane_size(std::span<const std::byte> png) {
  constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  constexpr std::size_t kSides = 16;  // after the signature, the header's length and its name
  if (png.size() < kSides + 8) return false;
  for (std::size_t i = 0; i < kSignature.size(); ++i) {
    if (std::to_integer<unsigned char>(png[i]) != kSignature[i]) return false;
  }
  for (std::size_t side = kSides; side < kSides + 8; side += 4) {
    std::uint32_t pixels = 0;
    for (std::size_t i = 0; i < 4; ++i) pixels = pixels << 8 | std::to_integer<std::uint32_t>(png[side + i]);
    if (pixels == 0 || pixels > kMostSide) return false;
  }
  return true;
}

}  // namespace

std::string picture_uri(std::span<const std::byte> png, int most_columns) {
  if (!is_png_of_sane_size(png)) return "";
  try {
    std::vector<unsigned char> bytes(png.size());
    std::transform(png.begin(), png.end(), bytes.begin(),
                   [](std::byte b) { return std::to_integer<unsigned char>(b); });
    cv::Mat picture = cv::imdecode(bytes, cv::IMREAD_COLOR);
    if (picture.empty()) return "";
    if (picture.cols > most_columns) {
      const int rows = std::max(1, picture.rows * most_columns / picture.cols);
      cv::resize(picture, picture, {most_columns, rows}, 0, 0, cv::INTER_AREA);
    }
    std::vector<unsigned char> jpeg;
    if (!cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) return "";
    return "data:image/jpeg;base64," + base64(std::as_bytes(std::span(jpeg)));
  } catch (const std::exception&) {  // cv::Exception, bad_alloc: the page is worth having without it
    return "";
  }
}

}  // namespace scanknit
