#include "acquire/replay/picture_codec.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"
#include "core/picture/png_codec.h"
#include "core/picture/png_structure.h"

namespace scanknit {
namespace {

constexpr std::uint16_t kSaturated = std::numeric_limits<std::uint16_t>::max();

template <typename T>
Result<Image<T>> decode_grey(std::span<const std::byte> bytes, const Limits& limits, const char* expected) {
  const auto file = check_png(bytes, limits);
  if (!file) return file.error();
  const PngHeader& header = file->header;
  if (header.bit_depth != static_cast<int>(8 * sizeof(T)) || !header.is_grey) {
    return Error{ErrorCode::kInput, std::to_string(header.bit_depth) + "-bit " + (header.is_grey ? "grey" : "colour") +
                                        " PNG; expected " + expected};
  }
  return decode_png_grey<T>(*file);
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
  auto colour = picture_or_drop(decode_picture(std::get<0>(bytes), settings.limits), entry.colour);
  if (auto* drop = std::get_if<Drop>(&colour)) return std::move(*drop);
  frame.colour = std::get<ColourImage>(std::move(colour));
  frame.encoded_colour = std::make_shared<const std::vector<std::byte>>(std::get<0>(std::move(bytes)));
  return frame;
}

OrDrop<DecodedFrame> decode_png_frame_of_one_lens(const FrameEntry& entry, const DecodeSettings& settings) {
  auto decoded = decode_png_frame(entry, settings);
  auto* frame = std::get_if<DecodedFrame>(&decoded);
  if (frame == nullptr || !entry.camera) return decoded;
  frame->camera = entry.camera->resized(frame->depth_m.width(), frame->depth_m.height());
  if (!frame->colour.empty()) {
    frame->colour_camera = entry.camera->resized(frame->colour.width(), frame->colour.height());
  }
  return decoded;
}

}  // namespace scanknit
