// The messages of ROS 2 and ROS 1 that tell of depth, colour, cameras and poses (common_interfaces, tf2_msgs).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/bag/ros_message.h"
#include "acquire/replay/undistort.h"
#include "acquire/ros2/cdr_reader.h"
#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// std_msgs/Header. `frame` has no slash in front.
struct Ros2Header {
  std::int64_t stamp_ns = 0;
  std::string frame;
};

/// sensor_msgs/Image. `data` points into the message.
struct Ros2Image {
  Ros2Header header;
  std::uint32_t width = 0, height = 0;
  std::string encoding;  ///< "16UC1", "rgb8"
  bool is_big_endian = false;
  std::uint32_t step = 0;  ///< bytes of a row
  std::span<const std::byte> data;
};

/// sensor_msgs/CompressedImage. `data` points into the message.
struct Ros2CompressedImage {
  Ros2Header header;
  std::string format;  ///< "jpeg", "rgb8; jpeg compressed bgr8", "16UC1; compressedDepth png"
  std::span<const std::byte> data;
};

/// sensor_msgs/CameraInfo.
struct Ros2Camera {
  CameraIntrinsics raw, rectified;                ///< by the matrices K and P
  RationalDistortion distortion{};                ///< of the raw picture
  std::optional<FisheyeDistortion> fisheye = {};  ///< in its place
  bool has_other_lens = false;  ///< its distortion is of another kind, or has more coefficients, and is left out

  friend bool operator==(const Ros2Camera&, const Ros2Camera&) = default;
};

struct Ros2Transform {
  std::int64_t stamp_ns = 0;
  std::string parent, child;
  Result<Pose> T_parent_child;  ///< an Error: why it is not rigid
};

/// std_msgs/Header, with which a message begins. Nothing: truncated.
[[nodiscard]] std::optional<Ros2Header> take_header(CdrReader& reader);

// Each reads one message. Errors (kInput, without `where`): truncated, no plain CDR, or as stated.

[[nodiscard]] Result<Ros2Image> parse_image(const RosMessage& message);
[[nodiscard]] Result<Ros2CompressedImage> parse_compressed_image(const RosMessage& message);

/// Errors also: no valid camera; binning or a region of interest, which change the camera.
[[nodiscard]] Result<Ros2Camera> parse_camera_info(const RosMessage& message);

/// tf2_msgs/TFMessage. Errors also: more than 1000 transforms.
[[nodiscard]] Result<std::vector<Ros2Transform>> parse_transforms(const RosMessage& message);

/// nav_msgs/Odometry as the transform from its header's frame to its child.
[[nodiscard]] Result<Ros2Transform> parse_odometry(const RosMessage& message);

/// geometry_msgs/PoseStamped and PoseWithCovarianceStamped, with an empty child.
[[nodiscard]] Result<Ros2Transform> parse_pose_stamped(const RosMessage& message);

}  // namespace scanknit
