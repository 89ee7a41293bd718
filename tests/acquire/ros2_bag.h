// Bags of ROS 2 that tests write for themselves: CDR messages of both byte orders, MCAP files of all packings.
#pragma once

#include <lz4frame.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
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
  explicit CdrWriter(bool is_little) : is_little_(is_little), bytes_{std::byte{0}, std::byte(is_little), {}, {}} {}

  template <typename T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(std::byte{0xEE});
    ByteAppender(bytes_).little_endian(value);
    if (!is_little_) std::reverse(bytes_.end() - sizeof(T), bytes_.end());
    return *this;
  }
  CdrWriter& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    ByteAppender(bytes_).append(std::as_bytes(std::span(text)));
    bytes_.push_back({});
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
    number(static_cast<std::int32_t>(time_ns / 1'000'000'000));
    number(static_cast<std::uint32_t>(time_ns % 1'000'000'000));
    return text(frame);
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  bool is_little_;
  Bytes bytes_;
};

/// The messages of one byte order.
struct Ros2Writer {
  bool is_little = true;

  [[nodiscard]] CdrWriter begin(std::int64_t time_ns, std::string_view frame) const {
    return CdrWriter(is_little).header(time_ns, frame);
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
    CdrWriter writer(is_little);
    return writer.number(std::uint32_t{1}).header(time_ns, parent).text(child).numbers(pose).bytes();
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
  void add(const std::string& topic, const std::string& type, std::int64_t log_ns, const Bytes& data) {
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

  std::map<std::string, std::uint16_t> channels_;
  Bytes definitions_, messages_;
};

constexpr const char* kImageType = "sensor_msgs/msg/Image";
constexpr const char* kCompressedType = "sensor_msgs/msg/CompressedImage";
constexpr const char* kCameraType = "sensor_msgs/msg/CameraInfo";
constexpr const char* kTransformType = "tf2_msgs/msg/TFMessage";

/// `count` values of 16 bits that count upwards from `first`, little endian.
[[nodiscard]] inline Bytes counted_depth(std::uint16_t first, std::size_t count) {
  Bytes data;
  for (std::size_t i = 0; i < count; ++i) ByteAppender(data).little_endian(static_cast<std::uint16_t>(first + i));
  return data;
}

/// A robot's depth camera of 4 x 2 pixels, its colour camera, which is 15 mm to the right, and their way: at 1 s in (1,
/// 0, 0), at 1.05 s in (2, 0, 0), looking along the world's x.
[[nodiscard]] inline Ros2Bag robot_bag(bool is_little = true) {
  constexpr std::int64_t kSecond = 1'000'000'000, kLater = 1'050'000'000;
  const Ros2Writer ros{is_little};
  Ros2Bag bag;
  // x forward, y left, z up becomes x right, y down, z forward.
  const std::vector<double> to_optical = {0, 0, 0, -0.5, 0.5, -0.5, 0.5};
  bag.add("/tf_static", kTransformType, 5, ros.transform(0, "base", "/depth_link", to_optical));
  bag.add("/tf_static", kTransformType, 5, ros.transform(0, "depth_link", "colour_link", {0.015, 0, 0, 0, 0, 0, 1}));
  bag.add("/cam/depth/camera_info", kCameraType, 6, ros.camera(4, 2, {4, 4.5, 1.5, 0.5}));
  bag.add("/cam/color/camera_info", kCameraType, 6, ros.camera(4, 2, {5, 5, 1.5, 0.5}));
  for (const std::int64_t time : {kSecond, kLater}) {
    const double x = time == kSecond ? 1 : 2;
    bag.add("/tf", kTransformType, time, ros.transform(time, "map", "base", {x, 0, 0, 0, 0, 0, 1}));
    bag.add("/cam/depth/image_raw", kImageType, time + 9,
            ros.image(time, "depth_link", "16UC1", 4, 2, counted_depth(1000, 8)));
    bag.add("/cam/color/image_raw", kImageType, time + 9,
            ros.image(time + 3, "colour_link", "bgr8", 4, 2, Bytes(24, std::byte{77})));
  }
  return bag;
}

}  // namespace scanknit::test
