#include "acquire/replay/picture_codec.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "core/files/read_file.h"
#include "core/picture/jpeg_structure.h"
#include "core/picture/png_structure.h"

namespace scanknit {
namespace {

constexpr std::uint16_t kSaturated = std::numeric_limits<std::uint16_t>::max();

// Checked bytes through OpenCV's decoder. The picture has the size that the header promised.
Result<cv::Mat> decode(std::span<const std::byte> bytes, int flags, int width, int height) {
  const Error failed{ErrorCode::kInput, "the picture's compressed data are corrupt"};
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return failed;
  try {
    cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1);
    std::memcpy(encoded.data, bytes.data(), bytes.size());
    cv::Mat picture = cv::imdecode(encoded, flags);
    if (picture.empty() || picture.cols != width || picture.rows != height) return failed;
    return picture;
  } catch (const std::exception&) {  // cv::Exception, std::bad_alloc
    return failed;
  }
}

template <typename T>
Image<T> copy_single_channel(const cv::Mat& picture) {
  Image<T> image(picture.cols, picture.rows);
  for (int y = 0; y < picture.rows; ++y) {
    std::copy_n(picture.ptr<T>(y), picture.cols, image.row(y).begin());
  }
  return image;
}

template <typename T>
Result<Image<T>> decode_grey(std::span<const std::byte> bytes, const Limits& limits, const char* expected) {
  const auto file = check_png(bytes, limits);
  if (!file) return file.error();
  const PngHeader& header = file->header;
  if (header.bit_depth != static_cast<int>(8 * sizeof(T)) || !header.is_grey) {
    return Error{ErrorCode::kInput, std::to_string(header.bit_depth) + "-bit " + (header.is_grey ? "grey" : "colour") +
                                        " PNG; expected " + expected};
  }
  auto picture = decode(file->critical, cv::IMREAD_UNCHANGED, header.width, header.height);
  if (!picture) return picture.error();
  if (picture->type() != cv::traits::Type<T>::value) return Error{ErrorCode::kInput, "the picture changed its type"};
  return copy_single_channel<T>(*picture);
}

ColourImage copy_bgr(const cv::Mat& picture) {
  ColourImage image(picture.cols, picture.rows);
  for (int y = 0; y < picture.rows; ++y) {
    std::transform(picture.ptr<cv::Vec3b>(y), picture.ptr<cv::Vec3b>(y) + picture.cols, image.row(y).begin(),
                   [](const cv::Vec3b& bgr) {
                     return Rgb8{bgr[2], bgr[1], bgr[0]};
                   });
  }
  return image;
}

// Depth below the wanted confidence becomes 0.
Result<void> apply_confidence(DepthImage& depth_m, const Image<std::uint8_t>& confidence, int min_confidence) {
  if (confidence.width() != depth_m.width() || confidence.height() != depth_m.height()) {
    return Error{ErrorCode::kInput, "the confidence picture is " + std::to_string(confidence.width()) + " x " +
                                        std::to_string(confidence.height()) + ", the depth picture " +
                                        std::to_string(depth_m.width()) + " x " + std::to_string(depth_m.height())};
  }
  std::transform(depth_m.pixels().begin(), depth_m.pixels().end(), confidence.pixels().begin(),
                 depth_m.pixels().begin(),
                 [&](float depth, std::uint8_t trust) { return trust >= min_confidence ? depth : 0.0F; });
  return {};
}

OrDrop<DepthImage> read_depth(const FrameEntry& entry, const DecodeSettings& settings) {
  auto bytes = read_picture(entry.depth, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto raw = decode_depth_png(std::get<0>(bytes), settings.limits);
  if (!raw) return make_drop(DropReason::kUnreadable, raw.error().message, entry.depth);
  DepthImage depth_m = scale_depth(*raw, settings.depth_scale);
  if (entry.confidence.empty() || settings.min_confidence <= 0) return depth_m;

  bytes = read_picture(entry.confidence, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  const auto confidence = decode_grey_png(std::get<0>(bytes), settings.limits);
  if (!confidence) return make_drop(DropReason::kUnreadable, confidence.error().message, entry.confidence);
  if (const auto applied = apply_confidence(depth_m, *confidence, settings.min_confidence); !applied) {
    return make_drop(DropReason::kSizeMismatch, applied.error().message, entry.confidence);
  }
  return depth_m;
}

}  // namespace

Result<Image<std::uint16_t>> decode_depth_png(std::span<const std::byte> bytes, const Limits& limits) {
  return decode_grey<std::uint16_t>(bytes, limits, "depth as a 16-bit grey PNG");
}

Result<Image<std::uint8_t>> decode_grey_png(std::span<const std::byte> bytes, const Limits& limits) {
  return decode_grey<std::uint8_t>(bytes, limits, "confidence as an 8-bit grey PNG");
}

Result<ColourImage> decode_colour(std::span<const std::byte> bytes, const Limits& limits) {
  constexpr int kFlags = cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION;
  if (looks_like_jpeg(bytes)) {
    const auto header = check_jpeg(bytes, limits);
    if (!header) return header.error();
    auto picture = decode(bytes, kFlags, header->width, header->height);
    if (!picture) return picture.error();
    return copy_bgr(*picture);
  }
  const auto file = check_png(bytes, limits);
  if (!file) {
    const bool is_other = file.error().message == "not a PNG file";
    return is_other ? Error{ErrorCode::kInput, "neither a PNG nor a JPEG file"} : file.error();
  }
  auto picture = decode(file->critical, kFlags, file->header.width, file->header.height);
  if (!picture) return picture.error();
  return copy_bgr(*picture);
}

DepthImage scale_depth(const Image<std::uint16_t>& raw, double raw_per_metre) {
  DepthImage depth_m(raw.width(), raw.height());
  std::transform(raw.pixels().begin(), raw.pixels().end(), depth_m.pixels().begin(), [&](std::uint16_t value) {
    return value == kSaturated ? 0.0F : static_cast<float>(value / raw_per_metre);
  });
  return depth_m;
}

OrDrop<std::vector<std::byte>> read_picture(const std::filesystem::path& path, const Limits& limits) {
  std::error_code code;
  if (!std::filesystem::exists(path, code)) return make_drop(DropReason::kMissingFile, "no such file", path);
  auto bytes = read_file(path, limits.max_image_bytes);
  if (!bytes) return make_drop(DropReason::kUnreadable, bytes.error().message, path);
  return *std::move(bytes);
}

OrDrop<DecodedFrame> decode_png_frame(const FrameEntry& entry, const DecodeSettings& settings) {
  DecodedFrame frame;
  auto depth = read_depth(entry, settings);
  if (auto* drop = std::get_if<Drop>(&depth)) return std::move(*drop);
  frame.depth_m = std::get<DepthImage>(std::move(depth));
  if (entry.colour.empty()) return frame;

  auto bytes = read_picture(entry.colour, settings.limits);
  if (auto* drop = std::get_if<Drop>(&bytes)) return std::move(*drop);
  auto colour = picture_or_drop(decode_colour(std::get<0>(bytes), settings.limits), entry.colour);
  if (auto* drop = std::get_if<Drop>(&colour)) return std::move(*drop);
  frame.colour = std::get<ColourImage>(std::move(colour));
  frame.encoded_colour = std::make_shared<const std::vector<std::byte>>(std::get<0>(std::move(bytes)));
  return frame;
}

}  // namespace scanknit
