// Bags of ROS 2 that tests write for themselves: CDR messages of both byte orders, MCAP files of all packings; and
// messages of ROS 1.
#pragma once

#include <lz4frame.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "acquire/mcap/byte_appender.h"
#include "acquire/mcap/mcap_format.h"
#include "acquire/mcap/zstd_bytes.h"
#include "core/files/crc32.h"

namespace scanknit::test {

using Bytes = std::vector<std::byte>;

/// Writes what CdrReader reads.
class CdrWriter {
 public:
  explicit CdrWriter(bool is_little, bool is_ros1 = false) : is_little_(is_little), is_ros1_(is_ros1) {
    if (!is_ros1) bytes_ = {std::byte{0}, std::byte(is_little), {}, {}};
  }

  template <typename T>
  CdrWriter& number(T value) {
    while (!is_ros1_ && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(std::byte{0xEE});
    ByteAppender(bytes_).little_endian(value);
    if (!is_little_) std::reverse(bytes_.end() - sizeof(T), bytes_.end());
    return *this;
  }
  CdrWriter& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + (is_ros1_ ? 0 : 1)));
    ByteAppender(bytes_).append(std::as_bytes(std::span(text)));
    if (!is_ros1_) bytes_.push_back({});
    return *this;
  }
  CdrWriter& sequence(const Bytes& data) {
    number(static_cast<std::uint32_t>(data.size()));
    ByteAppender(bytes_).append(data);
    return *this;
  }
  CdrWriter& numbers(const std::vector<double>& values) {
    for (const double value : values) number(value);
    return *this;
  }
  CdrWriter& header(std::int64_t time_ns, std::string_view frame) {
    if (is_ros1_) number(std::uint32_t{7});  // the message's number
    number(static_cast<std::int32_t>(time_ns / 1'000'000'000));
    number(static_cast<std::uint32_t>(time_ns % 1'000'000'000));
    return text(frame);
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  bool is_little_;
  bool is_ros1_;
  Bytes bytes_;
};

/// The messages of one byte order.
struct Ros2Writer {
  bool is_little = true;
  bool is_ros1 = false;

  [[nodiscard]] CdrWriter begin(std::int64_t time_ns, std::string_view frame) const {
    return CdrWriter(is_little, is_ros1).header(time_ns, frame);
  }
  /// Rows are padded by `padding` bytes, which `data` has. `is_big_endian` tells of the pixels, not of the message.
  [[nodiscard]] Bytes image(std::int64_t time_ns, std::string_view frame, std::string_view encoding,
                            std::uint32_t width, std::uint32_t height, const Bytes& data,
                            bool is_big_endian = false) const {
    CdrWriter writer = begin(time_ns, frame).number(height).number(width).text(encoding);
    writer.number(static_cast<std::uint8_t>(is_big_endian)).number(static_cast<std::uint32_t>(data.size() / height));
    return writer.sequence(data).bytes();
  }
  [[nodiscard]] Bytes compressed(std::int64_t time_ns, std::string_view frame, std::string_view format,
                                 const Bytes& data) const {
    return begin(time_ns, frame).text(format).sequence(data).bytes();
  }
  /// `k`: fx fy cx cy; P's focal lengths are twice as long.
  [[nodiscard]] Bytes camera(std::uint32_t width, std::uint32_t height, const std::array<double, 4>& k,
                             std::string_view lens = "plumb_bob", const std::vector<double>& d = {0, 0, 0, 0, 0},
                             std::uint32_t binning = 0) const {
    CdrWriter writer = begin(0, "ignored").number(height).number(width).text(lens);
    writer.number(static_cast<std::uint32_t>(d.size())).numbers(d);
    writer.numbers({k[0], 0, k[2], 0, k[1], k[3], 0, 0, 1}).numbers({1, 0, 0, 0, 1, 0, 0, 0, 1});
    writer.numbers({2 * k[0], 0, k[2], 0, 0, 2 * k[1], k[3], 0, 0, 0, 1, 0}).number(binning).number(binning);
    for (int i = 0; i < 4; ++i) writer.number(std::uint32_t{0});
    return writer.number(std::uint8_t{0}).bytes();
  }
  /// `pose`: x y z and a quaternion x y z w.
  [[nodiscard]] Bytes transform(std::int64_t time_ns, std::string_view parent, std::string_view child,
                                const std::vector<double>& pose) const {
    CdrWriter writer(is_little, is_ros1);
    return writer.number(std::uint32_t{1}).header(time_ns, parent).text(child).numbers(pose).bytes();
  }
  /// sensor_msgs/PointCloud2 of points of 20 bytes: x, y, z, four unused, rgb; rows are padded by eight bytes.
  /// `points`: x, y, z and 0x00RRGGBB.
  [[nodiscard]] Bytes cloud(std::int64_t time_ns, std::string_view frame, std::uint32_t width, std::uint32_t height,
                            const std::vector<std::tuple<float, float, float, std::uint32_t>>& points,
                            bool is_big_endian = false) const {
    constexpr std::uint32_t kStep = 20, kPadding = 8;
    constexpr std::uint8_t kFloat32 = 7;
    CdrWriter writer = begin(time_ns, frame).number(height).number(width).number(std::uint32_t{4});
    for (const auto& [name, offset] : {std::pair{"x", 0u}, {"y", 4u}, {"z", 8u}, {"rgb", 16u}}) {
      writer.text(name).number(offset).number(kFloat32).number(std::uint32_t{1});
    }
    const std::uint32_t row = width * kStep + kPadding;
    writer.number(static_cast<std::uint8_t>(is_big_endian)).number(kStep).number(row);
    Bytes data;
    const auto add = [&](auto value) {
      ByteAppender(data).little_endian(value);
      if (is_big_endian) std::reverse(data.end() - sizeof(value), data.end());
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& [x, y, z, rgb] = points[i];
      for (const float value : {x, y, z, -1.0F}) add(value);
      add(rgb);
      if ((i + 1) % width == 0) data.resize(data.size() + kPadding);
    }
    return writer.sequence(data).number(std::uint8_t{1}).bytes();
  }
  [[nodiscard]] Bytes odometry(std::int64_t time_ns, std::string_view parent, std::string_view child,
                               const std::vector<double>& pose) const {
    return begin(time_ns, parent).text(child).numbers(pose).numbers(std::vector<double>(36 + 6 + 36)).bytes();
  }
  [[nodiscard]] Bytes pose(std::int64_t time_ns, std::string_view frame, const std::vector<double>& pose) const {
    return begin(time_ns, frame).numbers(pose).bytes();
  }
};

enum class BagPacking { kChunk, kZstd, kLz4, kNoChunk };

/// An MCAP file of one chunk, or of none.
class Ros2Bag {
 public:
  struct Logged {
    std::string topic, type;
    std::int64_t log_ns;
    Bytes data;
  };

  void add(const std::string& topic, const std::string& type, std::int64_t log_ns, const Bytes& data) {
    log_.push_back({topic, type, log_ns, data});
    const auto [place, is_new] = channels_.try_emplace(topic, static_cast<std::uint16_t>(channels_.size() + 1));
    if (is_new) {
      append_schema({place->second, type, "ros2msg", ""}, definitions_);
      append_channel({place->second, place->second, topic, "cdr"}, definitions_);
    }
    McapRecord record(McapOp::kMessage, messages_);
    ByteAppender writer(messages_);
    writer.little_endian(place->second);
    writer.little_endian(std::uint32_t{0});
    writer.little_endian(static_cast<std::uint64_t>(log_ns));
    writer.little_endian(static_cast<std::uint64_t>(log_ns));
    writer.append(data);
    record.close();
  }

  /// What was added, for other containers.
  [[nodiscard]] const std::vector<Logged>& log() const { return log_; }

  [[nodiscard]] Bytes file(BagPacking packing = BagPacking::kChunk, std::string_view profile = "ros2") const {
    Bytes bytes(kMcapMagic.begin(), kMcapMagic.end());
    ByteAppender writer(bytes);
    McapRecord header(McapOp::kHeader, bytes);
    writer.text(profile);
    writer.text("");
    header.close();
    Bytes records = definitions_;
    records.insert(records.end(), messages_.begin(), messages_.end());
    if (packing == BagPacking::kNoChunk) {
      writer.append(records);
    } else {
      append_chunk(bytes, records, packing);
    }
    McapRecord end(McapOp::kDataEnd, bytes);
    writer.little_endian(std::uint32_t{0});
    end.close();
    writer.append(kMcapMagic);
    return bytes;
  }

 private:
  static void append_chunk(Bytes& bytes, const Bytes& records, BagPacking packing) {
    McapRecord chunk(McapOp::kChunk, bytes);
    ByteAppender writer(bytes);
    writer.append(Bytes(16));  // its times
    writer.little_endian(std::uint64_t{records.size()});
    writer.little_endian(crc32(records));
    Bytes packed = records;
    if (packing == BagPacking::kZstd) packed = zstd_pack(records);
    if (packing == BagPacking::kLz4) {
      packed.resize(LZ4F_compressFrameBound(records.size(), nullptr));
      packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), records.data(), records.size(), nullptr));
    }
    writer.text(packing == BagPacking::kZstd ? "zstd" : packing == BagPacking::kLz4 ? "lz4" : "");
    writer.little_endian(std::uint64_t{packed.size()});
    writer.append(packed);
    chunk.close();
  }

  std::vector<Logged> log_;
  std::map<std::string, std::uint16_t> channels_;
  Bytes definitions_, messages_;
};

constexpr const char* kImageType = "sensor_msgs/msg/Image";
constexpr const char* kCompressedType = "sensor_msgs/msg/CompressedImage";
constexpr const char* kCameraType = "sensor_msgs/msg/CameraInfo";
constexpr const char* kTransformType = "tf2_msgs/msg/TFMessage";
constexpr const char* kCloudType = "sensor_msgs/msg/PointCloud2";

/// `count` values of 16 bits that count upwards from `first`, little endian.
[[nodiscard]] inline Bytes counted_depth(std::uint16_t first, std::size_t count) {
  Bytes data;
  for (std::size_t i = 0; i < count; ++i) ByteAppender(data).little_endian(static_cast<std::uint16_t>(first + i));
  return data;
}

/// A robot's depth camera of 4 x 2 pixels, its colour camera, which is 15 mm to the right, and their way: at 1 s in (1,
/// 0, 0), at 1.05 s in (2, 0, 0), looking along the world's x.
struct Robot {
  static constexpr std::int64_t kSecond = 1'000'000'000, kLater = 1'050'000'000;
  Ros2Writer ros = {};

  /// What stands still.
  void add_still(Ros2Bag& bag) const {
    // x forward, y left, z up becomes x right, y down, z forward.
    const std::vector<double> to_optical = {0, 0, 0, -0.5, 0.5, -0.5, 0.5};
    bag.add("/tf_static", kTransformType, 5, ros.transform(0, "base", "/depth_link", to_optical));
    bag.add("/tf_static", kTransformType, 5, ros.transform(0, "depth_link", "colour_link", {0.015, 0, 0, 0, 0, 0, 1}));
    bag.add("/cam/depth/camera_info", kCameraType, 6, ros.camera(4, 2, {4, 4.5, 1.5, 0.5}));
    bag.add("/cam/color/camera_info", kCameraType, 6, ros.camera(4, 2, {5, 5, 1.5, 0.5}));
  }
  void add_frame(Ros2Bag& bag, std::int64_t time, double x) const {
    bag.add("/tf", kTransformType, time, ros.transform(time, "map", "base", {x, 0, 0, 0, 0, 0, 1}));
    bag.add("/cam/depth/image_raw", kImageType, time + 9,
            ros.image(time, "depth_link", "16UC1", 4, 2, counted_depth(1000, 8)));
    bag.add("/cam/color/image_raw", kImageType, time + 9,
            ros.image(time + 3, "colour_link", "bgr8", 4, 2, Bytes(24, std::byte{77})));
  }
  [[nodiscard]] Ros2Bag bag() const {
    Ros2Bag bag;
    add_still(bag);
    add_frame(bag, kSecond, 1);
    add_frame(bag, kLater, 2);
    return bag;
  }
};

[[nodiscard]] inline Ros2Bag robot_bag(bool is_little = true) {
  return Robot{{is_little}}.bag();
}

}  // namespace scanknit::test
