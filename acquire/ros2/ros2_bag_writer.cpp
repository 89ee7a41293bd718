#include "acquire/ros2/ros2_bag_writer.h"

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/picture/jpeg_structure.h"

namespace scanknit {
namespace {

struct Definition {
  const char* name;
  const char* text;
};
constexpr Definition kTime{"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"};
constexpr Definition kHeader{"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"};
constexpr Definition kImage{"sensor_msgs/msg/Image",
                            "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\n"
                            "uint8 is_bigendian\nuint32 step\nuint8[] data\n"};
constexpr Definition kCompressed{"sensor_msgs/msg/CompressedImage",
                                 "std_msgs/Header header\nstring format\nuint8[] data\n"};
constexpr Definition kCamera{"sensor_msgs/msg/CameraInfo",
                             "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n"
                             "float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n"
                             "uint32 binning_y\nsensor_msgs/RegionOfInterest roi\n"};
constexpr Definition kRegion{"sensor_msgs/RegionOfInterest",
                             "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"};
constexpr Definition kTransforms{"tf2_msgs/msg/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"};
constexpr Definition kStamped{"geometry_msgs/TransformStamped",
                              "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"};
constexpr Definition kTransform{"geometry_msgs/Transform",
                                "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"};
constexpr Definition kVector{"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"};
constexpr Definition kQuaternion{"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"};

/// `parts`: the messages of which it consists, in MCAP's encoding "ros2msg".
McapSchema schema(std::uint16_t id, const Definition& message, const std::vector<Definition>& parts) {
  std::string text = message.text;
  for (const Definition& part : parts) text += std::string(80, '=') + "\nMSG: " + part.name + "\n" + part.text;
  return {id, message.name, "ros2msg", text};
}

std::vector<McapSchema> schemas() {
  return {schema(1, kImage, {kHeader, kTime}), schema(2, kCompressed, {kHeader, kTime}),
          schema(3, kCamera, {kRegion, kHeader, kTime}),
          schema(4, kTransforms, {kStamped, kTransform, kVector, kQuaternion, kHeader, kTime})};
}

/// rosbag2's words for "kept for those who subscribe later", without which nobody hears of /tf_static.
constexpr const char* kLatched =
    "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n"
    "  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n"
    "  avoid_ros_namespace_conventions: false\n";

/// All topics but those of the other kind of colour.
std::vector<McapChannel> channels(const Ros2BagLayout& layout) {
  const auto channel = [](Ros2Topic topic, std::uint16_t schema_id, const char* name) {
    return McapChannel{static_cast<std::uint16_t>(topic), schema_id, name, "cdr"};
  };
  std::vector<McapChannel> channels = {channel(Ros2Topic::kDepth, 1, layout.depth_topic),
                                       channel(Ros2Topic::kDepthCamera, 3, "/camera/depth/camera_info"),
                                       layout.is_colour_packed
                                           ? channel(Ros2Topic::kPackedColour, 2, "/camera/color/image_raw/compressed")
                                           : channel(Ros2Topic::kColour, 1, "/camera/color/image_raw"),
                                       channel(Ros2Topic::kColourCamera, 3, "/camera/color/camera_info"),
                                       channel(Ros2Topic::kTf, 4, "/tf"),
                                       channel(Ros2Topic::kTfStatic, 4, "/tf_static")};
  channels.back().metadata = {{"offered_qos_profiles", kLatched}};
  return channels;
}

}  // namespace

Ros2BagWriter::Ros2BagWriter(ByteSink sink, const Ros2BagLayout& layout)
    : mcap_(std::move(sink), schemas(), channels(layout), "ros2") {}

void Ros2BagWriter::set_time(std::int64_t stamp_ns, std::int64_t recorded_ns) {
  stamp_ns_ = stamp_ns;
  recorded_ns_ = recorded_ns;
}

void Ros2BagWriter::add(Ros2Topic topic, const CdrWriter& message) {
  mcap_.add({static_cast<std::uint16_t>(topic), counts_[topic]++, static_cast<std::uint64_t>(recorded_ns_),
             static_cast<std::uint64_t>(recorded_ns_), message.bytes()});
}

void Ros2BagWriter::add_transform(Ros2Topic topic, const char* parent, const char* child, const Pose& T_parent_child) {
  const Eigen::Vector3d t = T_parent_child.translation();
  const Eigen::Quaterniond q(T_parent_child.linear());
  CdrWriter message;
  message.number(std::uint32_t{1});
  message.header(stamp_ns_, parent);
  message.text(child);
  message.numbers(std::array{t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  add(topic, message);
}

void Ros2BagWriter::add_camera(Ros2Topic topic, const char* frame_id, const CameraModel& camera) {
  const auto [width, height, fx, fy, cx, cy] = camera.intrinsics;
  CdrWriter message;
  message.header(stamp_ns_, frame_id);
  message.number(static_cast<std::uint32_t>(height));
  message.number(static_cast<std::uint32_t>(width));
  message.text("plumb_bob");
  message.number(static_cast<std::uint32_t>(camera.distortion.size()));
  message.numbers(camera.distortion);
  message.numbers(std::array{fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0});
  message.numbers(std::array{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
  message.numbers(std::array{fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0});
  for (int i = 0; i < 2 + 4; ++i) message.number(std::uint32_t{0});  // no binning, the whole picture
  message.number(std::uint8_t{0});
  add(topic, message);
}

void Ros2BagWriter::add_image(Ros2Topic topic, const char* frame_id, const char* encoding, int width, int height,
                              std::span<const std::byte> pixels) {
  CdrWriter message;
  message.header(stamp_ns_, frame_id);
  message.number(static_cast<std::uint32_t>(height));
  message.number(static_cast<std::uint32_t>(width));
  message.text(encoding);
  message.number(std::uint8_t{0});
  message.number(static_cast<std::uint32_t>(pixels.size() / static_cast<std::size_t>(height)));
  message.sequence(pixels);
  add(topic, message);
}

void Ros2BagWriter::add_packed_colour(const char* frame_id, std::span<const std::byte> file) {
  CdrWriter message;
  message.header(stamp_ns_, frame_id);
  message.text(looks_like_jpeg(file) ? "jpeg" : "png");
  message.sequence(file);
  add(Ros2Topic::kPackedColour, message);
}

}  // namespace scanknit
