// The pictures of a frame from their files: 16-bit depth, 8-bit confidence, colour.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "acquire/replay/recording.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// A grey PNG of 16 bits. Errors (kInput, without `where`): see check_png; another kind of PNG; not decodable.
[[nodiscard]] Result<Image<std::uint16_t>> decode_depth_png(std::span<const std::byte> bytes, const Limits& limits);

/// A grey PNG of 8 bits.
[[nodiscard]] Result<Image<std::uint8_t>> decode_grey_png(std::span<const std::byte> bytes, const Limits& limits);

/// Raw depth as metres. 0 and 65535 are "no return". `raw_per_metre` > 0.
[[nodiscard]] DepthImage scale_depth(const Image<std::uint16_t>& raw, double raw_per_metre);

/// The decoder of every layout that keeps depth in a PNG: depth, colour and confidence files of `entry`.
[[nodiscard]] OrDrop<DecodedFrame> decode_png_frame(const FrameEntry& entry, const DecodeSettings& settings);

/// The same where depth and colour are taken by one lens: `entry.camera`, if there is one, resized to each picture.
[[nodiscard]] OrDrop<DecodedFrame> decode_png_frame_of_one_lens(const FrameEntry& entry,
                                                                const DecodeSettings& settings);

/// The bytes of a picture file. Dropped: kMissingFile when it is not there, else kUnreadable.
[[nodiscard]] OrDrop<std::vector<std::byte>> read_picture(const std::filesystem::path& path, const Limits& limits);

/// `image`, or the drop (kUnreadable) that names `path`.
template <typename T>
[[nodiscard]] OrDrop<T> picture_or_drop(Result<T> image, const std::filesystem::path& path) {
  if (!image) return make_drop(DropReason::kUnreadable, image.error().message, path);
  return *std::move(image);
}

}  // namespace scanknit
