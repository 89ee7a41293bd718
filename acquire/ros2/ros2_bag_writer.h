// Ros2BagWriter: pictures, cameras and transforms as the messages that a robot records, in an MCAP file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

#include "acquire/acquire_config.h"
#include "acquire/mcap/mcap_writer.h"
#include "acquire/ros2/cdr_writer.h"
#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// The channels' ids in our bags. Readers use the names.
enum class Ros2Topic : std::uint16_t {
  kDepth = 1,
  kDepthCamera,
  kColour,
  kPackedColour,
  kColourCamera,
  kTf,
  kTfStatic
};

inline constexpr const char* kRos2World = "map";
inline constexpr const char* kRos2DepthFrame = "camera_depth_optical_frame";
inline constexpr const char* kRos2ColourFrame = "camera_color_optical_frame";

struct Ros2BagLayout {
  const char* depth_topic;        ///< "/camera/depth/image_rect_raw"; "rect" says that the pictures have no distortion
  bool is_colour_packed = false;  ///< colour is CompressedImage, not Image
};

/// Not thread-safe. add_*() write nothing until flush().
class Ros2BagWriter {
 public:
  Ros2BagWriter(ByteSink sink, const Ros2BagLayout& layout);

  [[nodiscard]] Result<void> begin() { return mcap_.begin(); }
  [[nodiscard]] std::size_t waiting_bytes() const { return mcap_.waiting_bytes(); }
  [[nodiscard]] Result<void> flush() { return mcap_.flush(); }
  [[nodiscard]] Result<void> finish() { return mcap_.finish(); }

  /// Of the messages that are added next: since 1970, 0 to 2^31 - 1 s. `recorded_ns`: when they came.
  void set_time(std::int64_t stamp_ns, std::int64_t recorded_ns);

  void add_transform(Ros2Topic topic, const char* parent, const char* child, const Pose& T_parent_child);
  void add_camera(Ros2Topic topic, const char* frame_id, const CameraModel& camera);
  /// `encoding`: one of sensor_msgs/image_encodings.h. `pixels`: rows without padding.
  void add_image(Ros2Topic topic, const char* frame_id, const char* encoding, int width, int height,
                 std::span<const std::byte> pixels);
  /// A JPEG or PNG file.
  void add_packed_colour(const char* frame_id, std::span<const std::byte> file);

 private:
  void add(Ros2Topic topic, const CdrWriter& message);

  McapWriter mcap_;
  std::int64_t stamp_ns_ = 0, recorded_ns_ = 0;
  std::map<Ros2Topic, std::uint32_t> counts_;
};

}  // namespace scanknit
