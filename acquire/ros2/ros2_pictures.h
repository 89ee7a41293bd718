// Pictures of ROS 2 messages: depth in metres, colour in RGB.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "acquire/bag/ros_message.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// What the pictures of a topic are, by the encoding of an Image or the format of a CompressedImage.
enum class Ros2Content {
  kNone,         ///< nothing that is read
  kRawDepth,     ///< 16 bits, in units
  kMetricDepth,  ///< floating point, in metres
  kColour,
  kGrey
};

/// "16UC1", "mono16": kRawDepth; "32FC1": kMetricDepth; "mono8": kGrey; "rgb8", "bgr8", "rgba8", "bgra8", YUV 4:2:2
/// ("yuv422", "uyvy", "yuv422_yuy2", "yuyv"; BT.601, video range) and Bayer mosaics of 8 bits ("bayer_rggb8", ...):
/// kColour.
[[nodiscard]] Ros2Content content_of_encoding(std::string_view encoding);

/// "16UC1; compressedDepth" and "32FC1; compressedDepth", with " png", " rvl" or neither: depth; whatever names jpeg or
/// png: kColour.
[[nodiscard]] Ros2Content content_of_format(std::string_view format);

// `message` is an Image, or where `is_compressed` a CompressedImage. Errors (kInput, without `where`): malformed,
// another content, contradicting itself about its size, beyond the limits.

/// Metres; 0 is "no return". `raw_per_metre` holds for 16 bits. Compressed depth of floating point is a quantised
/// inverse (compressed_depth_image_transport): z = a / (raw - b), with a and b from its head.
[[nodiscard]] Result<DepthImage> decode_ros2_depth(const RosMessage& message, bool is_compressed, double raw_per_metre,
                                                   const Limits& limits);

struct Ros2Colour {
  ColourImage image;
  std::shared_ptr<const std::vector<std::byte>> encoded = nullptr;  ///< the JPEG or PNG file; null: there was none
};

[[nodiscard]] Result<Ros2Colour> decode_ros2_colour(const RosMessage& message, bool is_compressed,
                                                    const Limits& limits);

}  // namespace scanknit
