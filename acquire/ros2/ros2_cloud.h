// sensor_msgs/PointCloud2 as a depth picture.
#pragma once

#include <optional>
#include <string>

#include "acquire/ros2/cloud_message.h"
#include "acquire/ros2/ros2_messages.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// What a cloud's message says of its points.
struct Ros2CloudHead {
  Ros2Header header;
  bool is_picture = false;  ///< rows of points, as a camera's picture has rows of pixels; else the sweep of a LiDAR
  bool has_colour = false;
};

struct Ros2CloudFrame {
  DepthImage depth_m;
  ColourImage colour;                      ///< empty: none
  std::optional<CameraIntrinsics> camera;  ///< fitted to the points; nothing: too few of them
};

/// Which laser of a LiDAR measured a point: a field "ring" (the drivers of Velodyne, Ouster, Hesai, RoboSense) or
/// "channel". Null: there is none. The field "line" of Livox is none: its lasers look everywhere.
[[nodiscard]] const CloudField* find_ring(const CloudMessage& cloud);

// Errors (kInput, without `where`): truncated; no x, y, z of floating point, in pictures of 32 bits; contradicting
// itself about its size.

[[nodiscard]] Result<Ros2CloudHead> parse_cloud_head(const RosMessage& message);

/// Errors also: not organised; beyond the limits; points that do not lie where a camera's pixels look.
[[nodiscard]] Result<Ros2CloudFrame> decode_ros2_cloud(const RosMessage& message, const Limits& limits);

}  // namespace scanknit
