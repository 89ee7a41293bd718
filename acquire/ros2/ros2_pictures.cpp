#include "acquire/ros2/ros2_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "acquire/replay/picture_codec.h"
#include "acquire/ros2/ros2_messages.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

/// The place of each channel in the bytes of a pixel.
struct Encoding {
  std::string_view name;
  Ros2Content content;
  std::size_t pixel_bytes;
  std::size_t red = 0, green = 0, blue = 0;
};
constexpr Encoding kEncodings[] = {
    {"16UC1", Ros2Content::kRawDepth, 2},        {"mono16", Ros2Content::kRawDepth, 2},
    {"32FC1", Ros2Content::kMetricDepth, 4},     {"rgb8", Ros2Content::kColour, 3, 0, 1, 2},
    {"bgr8", Ros2Content::kColour, 3, 2, 1, 0},  {"rgba8", Ros2Content::kColour, 4, 0, 1, 2},
    {"bgra8", Ros2Content::kColour, 4, 2, 1, 0}, {"mono8", Ros2Content::kGrey, 1}};

Error refuse(const std::string& what) {
  return {ErrorCode::kInput, what};
}

const Encoding* find_encoding(std::string_view name) {
  const auto* found = std::find_if(std::begin(kEncodings), std::end(kEncodings),
                                   [&](const Encoding& encoding) { return encoding.name == name; });
  return found == std::end(kEncodings) ? nullptr : found;
}

bool is_depth(Ros2Content content) {
  return content == Ros2Content::kRawDepth || content == Ros2Content::kMetricDepth;
}

/// The encoding of an image whose rows lie within its data.
Result<const Encoding*> check_image(const Ros2Image& image, const Limits& limits) {
  const Encoding* encoding = find_encoding(image.encoding);
  if (encoding == nullptr) return refuse("pictures of encoding '" + image.encoding + "' are not read");
  const auto pixels = checked_mul<std::uint64_t>(image.width, image.height);
  if (!pixels || *pixels == 0 || *pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return refuse("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                  " pixels is not read");
  }
  const bool fits = image.step >= std::uint64_t{image.width} * encoding->pixel_bytes &&
                    image.data.size() == std::uint64_t{image.step} * image.height;
  if (!fits) return refuse("the picture contradicts itself about its size");
  return encoding;
}

/// Calls `take(reader, pixel)` for each pixel of each row, in order.
template <typename Picture, typename Take>
Picture read_rows(const Ros2Image& image, const Encoding& encoding, Take take) {
  Picture picture(static_cast<int>(image.width), static_cast<int>(image.height));
  for (std::uint32_t y = 0; y < image.height; ++y) {
    ByteReader reader(image.data.subspan(std::size_t{y} * image.step, image.width * encoding.pixel_bytes));
    for (std::uint32_t x = 0; x < image.width; ++x) {
      picture.at(static_cast<int>(x), static_cast<int>(y)) = take(reader);
    }
  }
  return picture;
}

float valid_depth(float z) {
  return std::isfinite(z) && z > 0 ? z : 0.0F;
}

Result<DepthImage> decode_image_depth(const Ros2Image& image, double raw_per_metre, const Limits& limits) {
  const auto encoding = check_image(image, limits);
  if (!encoding) return encoding.error();
  const auto number = [&]<typename T>(ByteReader& reader, T) {
    return (image.is_big_endian ? reader.big_endian<T>() : reader.little_endian<T>()).value_or(0);
  };
  if ((*encoding)->content == Ros2Content::kRawDepth) {
    const auto raw = read_rows<Image<std::uint16_t>>(
        image, **encoding, [&](ByteReader& reader) { return number(reader, std::uint16_t{}); });
    return scale_depth(raw, raw_per_metre);
  }
  if ((*encoding)->content != Ros2Content::kMetricDepth) return refuse("'" + image.encoding + "' is no depth");
  return read_rows<DepthImage>(image, **encoding,
                               [&](ByteReader& reader) { return valid_depth(number(reader, 0.0F)); });
}

/// Twelve bytes (the codec's number and its two parameters, little endian), then a PNG.
Result<DepthImage> decode_compressed_depth(const Ros2CompressedImage& message, double raw_per_metre,
                                           const Limits& limits) {
  const Ros2Content content = content_of_format(message.format);
  if (!is_depth(content))
    return refuse("compressed pictures of format '" + message.format + "' are no depth that is read");
  constexpr std::size_t kHead = 12;
  ByteReader head(message.data);
  (void)head.little_endian<std::uint32_t>();
  const auto a = head.little_endian<float>();
  const auto b = head.little_endian<float>();
  if (!a || !b) return refuse("compressed depth is truncated");
  const auto raw = decode_depth_png(message.data.subspan(kHead), limits);
  if (!raw) return raw.error();
  if (content == Ros2Content::kRawDepth) return scale_depth(*raw, raw_per_metre);
  DepthImage depth_m(raw->width(), raw->height());
  std::transform(raw->pixels().begin(), raw->pixels().end(), depth_m.pixels().begin(), [&](std::uint16_t value) {
    return value == 0 ? 0.0F : valid_depth(*a / (static_cast<float>(value) - *b));
  });
  return depth_m;
}

}  // namespace

Ros2Content content_of_encoding(std::string_view encoding) {
  const Encoding* known = find_encoding(encoding);
  return known == nullptr ? Ros2Content::kNone : known->content;
}

Ros2Content content_of_format(std::string_view format) {
  const auto names = [&](std::string_view word) { return format.find(word) != std::string_view::npos; };
  if (names("compressedDepth")) {
    if (names("rvl")) return Ros2Content::kNone;
    return content_of_encoding(format.substr(0, format.find(';')));
  }
  return names("jpeg") || names("jpg") || names("png") ? Ros2Content::kColour : Ros2Content::kNone;
}

Result<DepthImage> decode_ros2_depth(std::span<const std::byte> message, bool is_compressed, double raw_per_metre,
                                     const Limits& limits) {
  if (is_compressed) {
    const auto picture = parse_compressed_image(message);
    return picture ? decode_compressed_depth(*picture, raw_per_metre, limits) : picture.error();
  }
  const auto image = parse_image(message);
  return image ? decode_image_depth(*image, raw_per_metre, limits) : image.error();
}

Result<Ros2Colour> decode_ros2_colour(std::span<const std::byte> message, bool is_compressed, const Limits& limits) {
  if (is_compressed) {
    const auto picture = parse_compressed_image(message);
    if (!picture) return picture.error();
    auto colour = decode_picture(picture->data, limits);
    if (!colour) return colour.error();
    return Ros2Colour{*std::move(colour),
                      std::make_shared<const std::vector<std::byte>>(picture->data.begin(), picture->data.end())};
  }
  const auto image = parse_image(message);
  if (!image) return image.error();
  const auto encoding = check_image(*image, limits);
  if (!encoding) return encoding.error();
  if (is_depth((*encoding)->content)) return refuse("'" + image->encoding + "' is no colour");
  const Encoding& known = **encoding;
  return Ros2Colour{read_rows<ColourImage>(*image, known, [&](ByteReader& reader) {
    const auto pixel = reader.take(known.pixel_bytes).value_or(std::span<const std::byte>());
    const auto channel = [&](std::size_t place) { return std::to_integer<std::uint8_t>(pixel[place]); };
    return Rgb8{channel(known.red), channel(known.green), channel(known.blue)};
  })};
}

}  // namespace scanknit
