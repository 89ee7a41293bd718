#include "acquire/ros2/ros2_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "acquire/raw/raw_decode.h"
#include "acquire/raw_frame.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/ros2/ros2_messages.h"
#include "acquire/ros2/rvl.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

/// How the bytes of a picture hold its colours.
enum class ColourLayout {
  kChannels,  ///< each pixel has all channels
  kYuv422,    ///< two pixels share their chroma
  kBayer,     ///< each pixel has one channel, in squares of 2 x 2
};

/// `places`: of red, green and blue in the bytes of a pixel; of a Bayer mosaic the channels of a square, row by row (0
/// red, 1 green, 2 blue).
struct Encoding {
  std::string_view name;
  Ros2Content content;
  std::size_t pixel_bytes;
  std::array<std::size_t, 4> places = {};
  ColourLayout layout = ColourLayout::kChannels;
  PixelFormat yuv = PixelFormat::kUyvy;
};
constexpr Encoding kEncodings[] = {
    {"16UC1", Ros2Content::kRawDepth, 2},
    {"mono16", Ros2Content::kRawDepth, 2},
    {"32FC1", Ros2Content::kMetricDepth, 4},
    {"mono8", Ros2Content::kGrey, 1},
    {"rgb8", Ros2Content::kColour, 3, {0, 1, 2}},
    {"bgr8", Ros2Content::kColour, 3, {2, 1, 0}},
    {"rgba8", Ros2Content::kColour, 4, {0, 1, 2}},
    {"bgra8", Ros2Content::kColour, 4, {2, 1, 0}},
    {"yuv422", Ros2Content::kColour, 2, {}, ColourLayout::kYuv422, PixelFormat::kUyvy},
    {"uyvy", Ros2Content::kColour, 2, {}, ColourLayout::kYuv422, PixelFormat::kUyvy},
    {"yuv422_yuy2", Ros2Content::kColour, 2, {}, ColourLayout::kYuv422, PixelFormat::kYuyv},
    {"yuyv", Ros2Content::kColour, 2, {}, ColourLayout::kYuv422, PixelFormat::kYuyv},
    {"bayer_rggb8", Ros2Content::kColour, 1, {0, 1, 1, 2}, ColourLayout::kBayer},
    {"bayer_bggr8", Ros2Content::kColour, 1, {2, 1, 1, 0}, ColourLayout::kBayer},
    {"bayer_gbrg8", Ros2Content::kColour, 1, {1, 2, 0, 1}, ColourLayout::kBayer},
    {"bayer_grbg8", Ros2Content::kColour, 1, {1, 0, 2, 1}, ColourLayout::kBayer}};

Error refuse_picture(const std::string& what) {
  return {ErrorCode::kInput, what};
}

Error refuse_size(std::uint32_t width, std::uint32_t height) {
  return refuse_picture("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                        " pixels is not read");
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
  if (encoding == nullptr) return refuse_picture("pictures of encoding '" + image.encoding + "' are not read");
  const auto pixels = checked_mul<std::uint64_t>(image.width, image.height);
  if (!pixels || *pixels == 0 || *pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return refuse_size(image.width, image.height);
  }
  const bool fits = image.step >= std::uint64_t{image.width} * encoding->pixel_bytes &&
                    image.data.size() == std::uint64_t{image.step} * image.height;
  if (!fits) return refuse_picture("the picture contradicts itself about its size");
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
  if ((*encoding)->content != Ros2Content::kMetricDepth) return refuse_picture("'" + image.encoding + "' is no depth");
  return read_rows<DepthImage>(image, **encoding,
                               [&](ByteReader& reader) { return valid_depth(number(reader, 0.0F)); });
}

bool is_rvl(std::string_view format) {
  return format.find("rvl") != std::string_view::npos;
}

/// Width and height, then what RVL packed.
Result<Image<std::uint16_t>> decode_rvl(std::span<const std::byte> bytes, const Limits& limits) {
  ByteReader reader(bytes);
  const auto width = reader.little_endian<std::uint32_t>();
  const auto height = reader.little_endian<std::uint32_t>();
  if (!width || !height) return refuse_picture("compressed depth is truncated");
  const std::uint64_t pixels = std::uint64_t{*width} * *height;
  if (pixels == 0 || pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) return refuse_size(*width, *height);
  const auto packed = reader.take(reader.remaining()).value_or(std::span<const std::byte>());
  auto raw = unpack_rvl(packed, static_cast<int>(*width), static_cast<int>(*height));
  if (!raw) return refuse_picture("depth that RVL compressed is truncated or corrupt");
  return *std::move(raw);
}

/// Twelve bytes (the codec's number and its two parameters, little endian), then a PNG or RVL.
Result<DepthImage> decode_compressed_depth(const Ros2CompressedImage& message, double raw_per_metre,
                                           const Limits& limits) {
  const Ros2Content content = content_of_format(message.format);
  if (!is_depth(content))
    return refuse_picture("compressed pictures of format '" + message.format + "' are no depth that is read");
  constexpr std::size_t kHead = 12;
  ByteReader head(message.data);
  (void)head.little_endian<std::uint32_t>();
  const auto a = head.little_endian<float>();
  const auto b = head.little_endian<float>();
  if (!a || !b) return refuse_picture("compressed depth is truncated");
  const auto packed = message.data.subspan(kHead);
  const auto raw = is_rvl(message.format) ? decode_rvl(packed, limits) : decode_depth_png(packed, limits);
  if (!raw) return raw.error();
  if (content == Ros2Content::kRawDepth) return scale_depth(*raw, raw_per_metre);
  DepthImage depth_m(raw->width(), raw->height());
  std::transform(raw->pixels().begin(), raw->pixels().end(), depth_m.pixels().begin(), [&](std::uint16_t value) {
    return value == 0 ? 0.0F : valid_depth(*a / (static_cast<float>(value) - *b));
  });
  return depth_m;
}

ColourImage decode_channels(const Ros2Image& image, const Encoding& encoding) {
  return read_rows<ColourImage>(image, encoding, [&](ByteReader& reader) {
    const auto pixel = reader.take(encoding.pixel_bytes).value_or(std::span<const std::byte>());
    const auto channel = [&](std::size_t colour) {
      return std::to_integer<std::uint8_t>(pixel[encoding.places[colour]]);
    };
    return Rgb8{channel(0), channel(1), channel(2)};
  });
}

Result<ColourImage> decode_yuv(const Ros2Image& image, const Encoding& encoding, const Limits& limits) {
  auto bytes = std::make_shared<std::vector<std::byte>>();
  const std::size_t row_bytes = std::size_t{image.width} * encoding.pixel_bytes;
  bytes->reserve(row_bytes * image.height);
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const auto row = image.data.subspan(std::size_t{y} * image.step, row_bytes);
    bytes->insert(bytes->end(), row.begin(), row.end());
  }
  const StreamProfile profile{StreamKind::kColour, encoding.yuv, static_cast<int>(image.width),
                              static_cast<int>(image.height)};
  return decode_raw_colour({.profile = profile, .bytes = std::move(bytes)}, limits);
}

/// Each channel that a pixel lacks is the mean of its neighbours that have it: bilinear interpolation.
ColourImage decode_bayer(const Ros2Image& image, const Encoding& encoding) {
  const auto raw = read_rows<Image<std::uint8_t>>(
      image, encoding, [](ByteReader& reader) { return reader.little_endian<std::uint8_t>().value_or(0); });
  const auto channel_at = [&](int x, int y) { return encoding.places[static_cast<std::size_t>(2 * (y % 2) + x % 2)]; };
  ColourImage picture(raw.width(), raw.height());
  for (int y = 0; y < raw.height(); ++y) {
    for (int x = 0; x < raw.width(); ++x) {
      std::array<int, 3> sum = {}, count = {};
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, raw.height() - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, raw.width() - 1); ++u) {
          sum[channel_at(u, v)] += raw.at(u, v);
          ++count[channel_at(u, v)];
        }
      }
      const std::size_t own = channel_at(x, y);
      sum[own] = raw.at(x, y);
      count[own] = 1;
      const auto mean = [&](std::size_t channel) {
        const int n = std::max(count[channel], 1);
        return static_cast<std::uint8_t>((sum[channel] + n / 2) / n);
      };
      picture.at(x, y) = {mean(0), mean(1), mean(2)};
    }
  }
  return picture;
}

}  // namespace

Ros2Content content_of_encoding(std::string_view encoding) {
  const Encoding* known = find_encoding(encoding);
  return known == nullptr ? Ros2Content::kNone : known->content;
}

Ros2Content content_of_format(std::string_view format) {
  const auto names = [&](std::string_view word) { return format.find(word) != std::string_view::npos; };
  if (names("compressedDepth")) {
    return content_of_encoding(format.substr(0, format.find(';')));
  }
  return names("jpeg") || names("jpg") || names("png") ? Ros2Content::kColour : Ros2Content::kNone;
}

Result<DepthImage> decode_ros2_depth(const RosMessage& message, bool is_compressed, double raw_per_metre,
                                     const Limits& limits) {
  if (is_compressed) {
    const auto picture = parse_compressed_image(message);
    return picture ? decode_compressed_depth(*picture, raw_per_metre, limits) : picture.error();
  }
  const auto image = parse_image(message);
  return image ? decode_image_depth(*image, raw_per_metre, limits) : image.error();
}

Result<Ros2Colour> decode_ros2_colour(const RosMessage& message, bool is_compressed, const Limits& limits) {
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
  if (is_depth((*encoding)->content)) return refuse_picture("'" + image->encoding + "' is no colour");
  switch ((*encoding)->layout) {
    case ColourLayout::kYuv422: {
      auto colour = decode_yuv(*image, **encoding, limits);
      if (!colour) return colour.error();
      return Ros2Colour{*std::move(colour)};
    }
    case ColourLayout::kBayer: return Ros2Colour{decode_bayer(*image, **encoding)};
    case ColourLayout::kChannels: break;
  }
  return Ros2Colour{decode_channels(*image, **encoding)};
}

}  // namespace scanknit
