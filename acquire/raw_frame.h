// RawFrame: the undecoded bytes of a scanner, with both clocks; and the data needed to decode them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/camera.h"
#include "core/frame.h"
#include "core/pose.h"

namespace scanknit {

/// The values are written into recordings.
enum class StreamKind : std::uint8_t { kDepth = 0, kColour = 1 };

/// The format of a picture's bytes. The values are written into recordings.
enum class PixelFormat : std::uint8_t {
  kZ16 = 0,   ///< depth, 16-bit little endian, in units of RawCalibration::depth_unit_m; 0 is "no return"
  kYuyv = 1,  ///< Y0 U Y1 V, BT.601
  kUyvy = 2,  ///< U Y0 V Y1
  kMjpeg = 3,
  kRgb8 = 4,
  kBgr8 = 5,
  kY8i = 6,  ///< the grey pictures of two cameras, side by side in each pixel: left, right
};

/// "z16", "yuyv", "uyvy", "mjpeg", "rgb8", "bgr8", "y8i".
[[nodiscard]] const char* to_string(PixelFormat format);

/// Mirrors rows of `width` pixels (at least one).
void mirror(std::vector<std::byte>& pixels, std::size_t width, std::size_t pixel_bytes);

/// One picture stream of a scanner, offered or started.
struct StreamProfile {
  StreamKind kind = StreamKind::kDepth;  ///< kDepth also of a pair of pictures, which depth is made of
  PixelFormat format = PixelFormat::kZ16;
  int width = 0;
  int height = 0;
  double frames_per_second = 0;  ///< 0: unknown

  friend bool operator==(const StreamProfile&, const StreamProfile&) = default;
};

/// The cameras of both streams. An unknown or absent camera has width 0.
struct RawCalibration {
  CameraModel depth;
  CameraModel colour;
  Pose T_colour_depth = Pose::Identity();
  double depth_unit_m = 0.001;      ///< metres of one raw unit, > 0
  std::string source;               ///< for messages: "the camera's own", "acquire.intrinsics"
  std::string device;               ///< for messages: the camera's name
  std::string serial;               ///< empty: unknown
  std::string depth_unknown = {};   ///< why the depth camera is unknown (its width is 0 then); empty: it is known
  std::string colour_unknown = {};  ///< why the colour camera's pose is unknown; empty: it is known
  std::vector<std::string> warnings = {};  ///< messages: values that were assumed because they could not be read
  double baseline_m = 0;  ///< of PixelFormat::kY8i, rectified pictures of two cameras like `depth`; 0: unknown
};

/// A complete picture. Cheap to copy: copies share the bytes, which never change.
struct RawFrame {
  StreamProfile profile;
  std::uint64_t sequence = 0;  ///< of its stream, strictly increasing; the camera's own frame counter if it has one
  std::int64_t device_ns = 0;  ///< the camera's clock, unwrapped; host_ns when it has none
  std::int64_t host_ns = 0;    ///< this computer's steady clock when the last byte arrived
  std::shared_ptr<const std::vector<std::byte>> bytes;
};

}  // namespace scanknit
