#include "export/texture/texture_picture.h"

#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "core/picture/jpeg_structure.h"
#include "core/picture/png_structure.h"
#include "export/mesh/mesh_builder.h"

namespace scanknit {
namespace {

/// Checked bytes, into the picture's own memory.
Result<ColourImage> decode(std::span<const std::byte> checked, int width, int height) {
  static_assert(sizeof(Rgb8) == 3);
  const Error corrupt = input_error("its compressed data are corrupt");
  if (checked.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return corrupt;
  try {
    cv::Mat encoded(1, static_cast<int>(checked.size()), CV_8UC1);
    std::memcpy(encoded.data, checked.data(), checked.size());
    ColourImage image(width, height);
    cv::Mat pixels(height, width, CV_8UC3, image.pixels().data());
    const cv::Mat decoded = cv::imdecode(encoded, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION, &pixels);
    const bool is_in_place = decoded.data == reinterpret_cast<const uchar*>(image.pixels().data());
    if (decoded.empty() || !is_in_place) return corrupt;  // elsewhere: not of the size that the header promised
    for (Rgb8& pixel : image.pixels()) std::swap(pixel.r, pixel.b);  // OpenCV's order is blue, green, red
    return image;
  } catch (const std::exception&) {  // cv::Exception, std::bad_alloc
    return corrupt;
  }
}

}  // namespace

Result<ColourImage> decode_texture(std::span<const std::byte> file, const Limits& limits) {
  if (looks_like_jpeg(file)) {
    const auto header = check_jpeg(file, limits);
    return header ? decode(file, header->width, header->height) : header.error();
  }
  const auto png = check_png(file, limits);
  if (png) return decode(png->critical, png->header.width, png->header.height);
  return png.error().message == "not a PNG file" ? input_error("neither a PNG nor a JPEG file") : png.error();
}

}  // namespace scanknit
