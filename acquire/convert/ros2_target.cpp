// A bag of ROS 2 in an MCAP file: depth, colour, their cameras and the camera's way, as the messages that a robot
// records.
#include <fmt/format.h>

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "acquire/convert/recording_target.h"
#include "acquire/mcap/mcap_writer.h"
#include "acquire/ros2/cdr_writer.h"
#include "core/files/atomic_file.h"
#include "core/picture/jpeg_structure.h"
#include "core/picture/png_codec.h"

namespace scanknit {
namespace {

constexpr const char* kWorld = "map";
constexpr const char* kDepthFrame = "camera_depth_optical_frame";
constexpr const char* kColourFrame = "camera_color_optical_frame";
constexpr double kMillimetres = 1000;  // units of 16UC1 (ROS REP 118)
constexpr std::size_t kChunkBytes = 8u << 20;

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

enum class Topic : std::uint16_t { kDepth = 1, kDepthCamera, kColour, kPackedColour, kColourCamera, kTf, kTfStatic };

/// All topics but those of the other kind of colour.
std::vector<McapChannel> channels(bool is_colour_packed) {
  const auto channel = [](Topic topic, std::uint16_t schema_id, const char* name) {
    return McapChannel{static_cast<std::uint16_t>(topic), schema_id, name, "cdr"};
  };
  std::vector<McapChannel> channels = {channel(Topic::kDepth, 1, "/camera/depth/image_rect_raw"),
                                       channel(Topic::kDepthCamera, 3, "/camera/depth/camera_info"),
                                       is_colour_packed
                                           ? channel(Topic::kPackedColour, 2, "/camera/color/image_raw/compressed")
                                           : channel(Topic::kColour, 1, "/camera/color/image_raw"),
                                       channel(Topic::kColourCamera, 3, "/camera/color/camera_info"),
                                       channel(Topic::kTf, 4, "/tf"),
                                       channel(Topic::kTfStatic, 4, "/tf_static")};
  channels.back().metadata = {{"offered_qos_profiles", kLatched}};
  return channels;
}

class Ros2Target final : public RecordingTarget {
 public:
  explicit Ros2Target(AtomicFile file) : file_(std::move(file)) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    constexpr std::int64_t kLatest_ns = std::int64_t{std::numeric_limits<std::int32_t>::max()} * 1'000'000'000;
    if (converted.time_ns < 0 || converted.time_ns > kLatest_ns) {
      return Error{ErrorCode::kInput,
                   fmt::format("frame {} has the time {} s, and a bag of ROS 2 holds times from 0 to 2147483647 s",
                               frame.sequence, static_cast<double>(converted.time_ns) * 1e-9)};
    }
    time_ns_ = converted.time_ns;
    if (!writer_) {
      is_colour_packed_ = !frame.colour || frame.colour->encoded;
      writer_.emplace([this](std::span<const std::byte> bytes) { return file_.write(bytes); }, schemas(),
                      channels(is_colour_packed_), "ros2");
      if (auto begun = writer_->begin(); !begun) return begun;
    }
    if (frame.T_world_camera) add_transform(Topic::kTf, kWorld, kDepthFrame, *frame.T_world_camera);
    add_camera(Topic::kDepthCamera, kDepthFrame, frame.intrinsics);
    add_depth(converted);
    if (frame.colour) {
      if (auto added = add_colour(frame); !added) return added;
    }
    return writer_->waiting_bytes() < kChunkBytes ? Result<void>() : writer_->flush();
  }

  [[nodiscard]] Result<void> finish() override {
    if (auto finished = writer_->finish(); !finished) return finished;
    return file_.commit();
  }

 private:
  void add(Topic topic, const CdrWriter& message) {
    const auto time_ns = static_cast<std::uint64_t>(time_ns_);
    writer_->add({static_cast<std::uint16_t>(topic), counts_[topic]++, time_ns, time_ns, message.bytes()});
  }

  void add_transform(Topic topic, const char* parent, const char* child, const Pose& T_parent_child) {
    const Eigen::Vector3d t = T_parent_child.translation();
    const Eigen::Quaterniond q(T_parent_child.linear());
    CdrWriter message;
    message.number(std::uint32_t{1});
    message.header(time_ns_, parent);
    message.text(child);
    message.numbers(std::array{t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
    add(topic, message);
  }

  void add_camera(Topic topic, const char* frame_id, const CameraIntrinsics& camera) {
    const auto [width, height, fx, fy, cx, cy] = camera;
    CdrWriter message;
    message.header(time_ns_, frame_id);
    message.number(static_cast<std::uint32_t>(height));
    message.number(static_cast<std::uint32_t>(width));
    message.text("plumb_bob");
    message.number(std::uint32_t{5});
    message.numbers(std::array<double, 5>{});  // the pictures have no distortion
    message.numbers(std::array{fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0});
    message.numbers(std::array{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
    message.numbers(std::array{fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0});
    for (int i = 0; i < 2 + 4; ++i) message.number(std::uint32_t{0});  // no binning, the whole picture
    message.number(std::uint8_t{0});
    add(topic, message);
  }

  void add_image(Topic topic, const char* frame_id, const char* encoding, int width, int height,
                 std::span<const std::byte> pixels) {
    CdrWriter message;
    message.header(time_ns_, frame_id);
    message.number(static_cast<std::uint32_t>(height));
    message.number(static_cast<std::uint32_t>(width));
    message.text(encoding);
    message.number(std::uint8_t{0});
    message.number(static_cast<std::uint32_t>(pixels.size() / static_cast<std::size_t>(height)));
    message.sequence(pixels);
    add(topic, message);
  }

  void add_depth(const ConvertedFrame& converted) {
    const DepthImage& depth_m = converted.frame.depth_m;
    std::vector<std::byte> pixels;
    ByteAppender appender(pixels);
    const bool is_millimetres = converted.units_per_metre == kMillimetres;
    if (is_millimetres) {
      for (const std::uint16_t depth : converted.raw_depth.pixels()) appender.little_endian(depth);
    } else {
      for (const float depth : depth_m.pixels()) {
        appender.little_endian(depth > 0 ? depth : std::numeric_limits<float>::quiet_NaN());
      }
    }
    add_image(Topic::kDepth, kDepthFrame, is_millimetres ? "16UC1" : "32FC1", depth_m.width(), depth_m.height(),
              pixels);
  }

  [[nodiscard]] Result<void> add_colour(const Frame& frame) {
    const ColourFrame& colour = *frame.colour;
    const char* frame_id = kDepthFrame;
    if (!is_registered(frame)) {
      frame_id = kColourFrame;
      if (!T_colour_depth_) {
        T_colour_depth_ = colour.T_colour_depth;
        add_transform(Topic::kTfStatic, kDepthFrame, kColourFrame, colour.T_colour_depth.inverse());
      } else if (!T_colour_depth_->isApprox(colour.T_colour_depth)) {
        warn("the colour camera's pose beside depth changes on the way; that of the first frame is kept");
      }
    }
    add_camera(Topic::kColourCamera, frame_id, colour.intrinsics);
    if (is_colour_packed_) return add_packed_colour(frame_id, colour);
    std::vector<std::byte> pixels;
    pixels.reserve(3 * colour.image.size());
    for (const Rgb8& pixel : colour.image.pixels()) {
      for (const std::uint8_t channel : {pixel.r, pixel.g, pixel.b}) pixels.push_back(std::byte{channel});
    }
    add_image(Topic::kColour, frame_id, "rgb8", colour.image.width(), colour.image.height(), pixels);
    return {};
  }

  /// The picture's file as it is; a picture that came from none, among others that did, as a PNG.
  [[nodiscard]] Result<void> add_packed_colour(const char* frame_id, const ColourFrame& colour) {
    std::vector<std::uint8_t> png;
    std::span<const std::byte> bytes;
    if (colour.encoded) {
      bytes = *colour.encoded;
    } else {
      auto encoded = encode_png(colour.image, PngEffort::kFast);
      if (!encoded) return encoded.error();
      png = *std::move(encoded);
      bytes = std::as_bytes(std::span(png));
    }
    CdrWriter message;
    message.header(time_ns_, frame_id);
    message.text(looks_like_jpeg(bytes) ? "jpeg" : "png");
    message.sequence(bytes);
    add(Topic::kPackedColour, message);
    return {};
  }

  AtomicFile file_;
  std::optional<McapWriter> writer_;
  bool is_colour_packed_ = false;  // by the first frame
  std::int64_t time_ns_ = 0;       // of the frame
  std::map<Topic, std::uint32_t> counts_;
  std::optional<Pose> T_colour_depth_;
};

}  // namespace

OpenedTarget open_ros2_target(const std::filesystem::path& path) {
  if (auto writable = check_writable(path); !writable) return writable.error();
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  return std::unique_ptr<RecordingTarget>(std::make_unique<Ros2Target>(*std::move(file)));
}

}  // namespace scanknit
