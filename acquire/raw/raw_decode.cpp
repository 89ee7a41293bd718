#include "acquire/raw/raw_decode.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "acquire/replay/picture_codec.h"
#include "acquire/replay/undistort.h"
#include "acquire/stereo/pair_depth.h"
#include "core/files/byte_reader.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

Error refused(const RawFrame& frame, const std::string& what) {
  return {ErrorCode::kInput, std::string("the ") + to_string(frame.profile.format) + " picture " +
                                 std::to_string(frame.sequence) + " " + what};
}

// Bytes of each pixel, for the formats where that is a number.
Result<void> check_size(const RawFrame& frame, std::size_t bytes_per_pixel, const Limits& limits) {
  const StreamProfile& profile = frame.profile;
  const std::int64_t pixels = std::int64_t{profile.width} * profile.height;
  if (profile.width <= 0 || profile.height <= 0 || pixels > limits.max_image_pixels) {
    return refused(frame, "of " + size_text(profile.width, profile.height) + " pixels is not read");
  }
  const std::size_t expected = static_cast<std::size_t>(pixels) * bytes_per_pixel;
  if (!frame.bytes || frame.bytes->size() != expected) {
    return refused(frame, "has " + std::to_string(frame.bytes ? frame.bytes->size() : 0) + " bytes, expected " +
                              std::to_string(expected));
  }
  return {};
}

std::uint8_t clamp_to_byte(int value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0, 255));
}

// ITU-R BT.601, luma 16 to 235: R = 1.164 (Y - 16) + 1.596 (V - 128) and so on, in 1/256, rounded.
Rgb8 from_yuv(int y, int u, int v) {
  const int luma = 298 * (y - 16) + 128;
  return {clamp_to_byte((luma + 409 * (v - 128)) >> 8), clamp_to_byte((luma - 100 * (u - 128) - 208 * (v - 128)) >> 8),
          clamp_to_byte((luma + 516 * (u - 128)) >> 8)};
}

// Two pixels in four bytes; `y0`, `u`, `y1`, `v` say where each is.
template <std::size_t Y0, std::size_t U, std::size_t Y1, std::size_t V>
ColourImage from_packed_yuv(const RawFrame& frame) {
  ColourImage image(frame.profile.width, frame.profile.height);
  const std::span<const std::byte> bytes = *frame.bytes;
  const auto pixels = image.pixels();
  for (std::size_t i = 0; i + 1 < pixels.size(); i += 2) {
    const auto at = [&](std::size_t k) { return std::to_integer<int>(bytes[2 * i + k]); };
    pixels[i] = from_yuv(at(Y0), at(U), at(V));
    pixels[i + 1] = from_yuv(at(Y1), at(U), at(V));
  }
  return image;
}

template <std::size_t R, std::size_t G, std::size_t B>
ColourImage from_triples(const RawFrame& frame) {
  ColourImage image(frame.profile.width, frame.profile.height);
  const std::span<const std::byte> bytes = *frame.bytes;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const auto at = [&](std::size_t k) { return std::to_integer<std::uint8_t>(bytes[3 * i + k]); };
    image.pixels()[i] = {at(R), at(G), at(B)};
  }
  return image;
}

Result<ColourImage> from_jpeg(const RawFrame& frame, const Limits& limits) {
  if (!frame.bytes) return refused(frame, "is empty");
  auto image = decode_picture(*frame.bytes, limits);
  if (!image) return refused(frame, "cannot be decoded: " + image.error().message);
  if (image->width() != frame.profile.width || image->height() != frame.profile.height) {
    return refused(frame, "is " + size_text(image->width(), image->height()) + ", its stream " +
                              size_text(frame.profile.width, frame.profile.height));
  }
  return image;
}

// The stream's size where the camera leaves it open (0), as in AcquireConfig::intrinsics.
Result<CameraModel> settle_camera(CameraModel camera, const RawFrame& frame) {
  CameraIntrinsics& k = camera.intrinsics;
  if (k.width == 0 && k.height == 0) {
    k.width = frame.profile.width;
    k.height = frame.profile.height;
  }
  if (!k.is_valid()) return refused(frame, "has no camera: its intrinsics are not known");
  if (k.width != frame.profile.width || k.height != frame.profile.height) {
    return refused(frame, "is " + size_text(frame.profile.width, frame.profile.height) + ", its camera " +
                              size_text(k.width, k.height));
  }
  return camera;
}

Result<ColourFrame> decode_with_camera(const RawFrame& frame, const CameraModel& model, const Pose& T_colour_depth,
                                       const Limits& limits) {
  const auto camera = settle_camera(model, frame);
  if (!camera) return camera.error();
  auto image = decode_raw_colour(frame, limits);
  if (!image) return image.error();
  ColourFrame colour{*std::move(image), camera->intrinsics, T_colour_depth};
  if (camera->distortion != Distortion{}) {
    colour.image = undistort(colour.image, camera->intrinsics, camera->distortion);
  } else if (frame.profile.format == PixelFormat::kMjpeg) {
    colour.encoded = frame.bytes;
  }
  return colour;
}

/// Also the left picture, rectified.
Result<DepthImage> depth_of_pair(const RawFrame& frame, const PairDepth& pairs, const Limits& limits,
                                 std::optional<ColourImage>& left) {
  const auto pair = decode_raw_pair(frame, limits);
  if (!pair) return pair.error();
  auto found = pairs.find(pair->left, pair->right);
  if (!found) return refused(frame, "could not be matched by OpenCV");
  left = std::move(found->left);
  if (found->share_known < PairDepth::kLeastKnown) return DepthImage(frame.profile.width, frame.profile.height);
  return std::move(found->depth_m);
}

}  // namespace

Result<DepthImage> decode_raw_depth(const RawFrame& frame, double depth_unit_m, const Limits& limits) {
  if (frame.profile.format != PixelFormat::kZ16) return refused(frame, "is no depth picture");
  if (const auto fits = check_size(frame, 2, limits); !fits) return fits.error();
  Image<std::uint16_t> raw(frame.profile.width, frame.profile.height);
  ByteReader reader(*frame.bytes);
  for (std::uint16_t& value : raw.pixels()) value = reader.little_endian<std::uint16_t>().value_or(0);
  return scale_depth(raw, 1 / depth_unit_m);
}

Result<ColourImage> decode_raw_colour(const RawFrame& frame, const Limits& limits) {
  const PixelFormat format = frame.profile.format;
  if (format == PixelFormat::kMjpeg) return from_jpeg(frame, limits);
  if (format == PixelFormat::kZ16 || format == PixelFormat::kY8i) return refused(frame, "is no colour picture");
  const bool is_yuv = format == PixelFormat::kYuyv || format == PixelFormat::kUyvy;
  if (const auto fits = check_size(frame, is_yuv ? 2 : 3, limits); !fits) return fits.error();
  if (is_yuv && frame.profile.width % 2 != 0) return refused(frame, "has an odd width, which its format cannot have");
  switch (format) {
    case PixelFormat::kYuyv: return from_packed_yuv<0, 1, 2, 3>(frame);
    case PixelFormat::kUyvy: return from_packed_yuv<1, 0, 3, 2>(frame);
    case PixelFormat::kBgr8: return from_triples<2, 1, 0>(frame);
    default: return from_triples<0, 1, 2>(frame);
  }
}

Result<GreyPair> decode_raw_pair(const RawFrame& frame, const Limits& limits) {
  if (frame.profile.format != PixelFormat::kY8i) return refused(frame, "is no pair of pictures");
  if (const auto fits = check_size(frame, 2, limits); !fits) return fits.error();
  const int width = frame.profile.width, height = frame.profile.height;
  GreyPair pair{ColourImage::uninitialised(width, height), ColourImage::uninitialised(width, height)};
  const std::span<const std::byte> bytes = *frame.bytes;
  for (std::size_t i = 0; i < pair.left.size(); ++i) {
    const auto left = std::to_integer<std::uint8_t>(bytes[2 * i]);
    const auto right = std::to_integer<std::uint8_t>(bytes[2 * i + 1]);
    pair.left.pixels()[i] = {left, left, left};
    pair.right.pixels()[i] = {right, right, right};
  }
  return pair;
}

Result<Frame> decode_raw_frame(const RawFrame& depth, const RawFrame* colour, const RawCalibration& calibration,
                               const Limits& limits, const PairDepth* pairs) {
  const auto camera = settle_camera(calibration.depth, depth);
  if (!camera) return camera.error();
  std::optional<ColourImage> left;
  auto depth_m = pairs != nullptr ? depth_of_pair(depth, *pairs, limits, left)
                                  : decode_raw_depth(depth, calibration.depth_unit_m, limits);
  if (!depth_m) return depth_m.error();
  Frame frame;
  frame.sequence = depth.sequence;
  frame.timestamp_ns = depth.device_ns;
  frame.has_clock = true;
  frame.intrinsics = camera->intrinsics;
  frame.depth_m = *std::move(depth_m);
  if (camera->distortion != Distortion{}) {
    frame.depth_m = undistort(frame.depth_m, frame.intrinsics, camera->distortion);
  }
  if (colour == nullptr && left) frame.colour = ColourFrame{*std::move(left), frame.intrinsics, Pose::Identity()};
  if (colour == nullptr) return frame;

  CameraModel colour_camera = calibration.colour;
  Pose T_colour_depth = calibration.T_colour_depth;
  if (colour_camera.intrinsics.width == 0) {
    const StreamProfile& profile = colour->profile;
    colour_camera = {frame.intrinsics.resized(profile.width, profile.height), camera->distortion};
    T_colour_depth = Pose::Identity();
  }
  auto decoded = decode_with_camera(*colour, colour_camera, T_colour_depth, limits);
  if (!decoded) return decoded.error();
  frame.colour = *std::move(decoded);
  return frame;
}

}  // namespace scanknit
