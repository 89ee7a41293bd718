// sensor_msgs/PointCloud2 as its fields and bytes, before it is known what they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/ros2/ros2_messages.h"
#include "core/files/byte_reader.h"
#include "core/result.h"

namespace scanknit {

/// sensor_msgs/PointField's numbers.
enum class CloudType : std::uint8_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8
};

/// Bytes; 0: no such type.
[[nodiscard]] std::size_t size_of(CloudType type);

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes, in a point
  CloudType type{};
  std::uint32_t count = 0;
};

/// `data` points into the message.
struct CloudMessage {
  Ros2Header header;
  std::uint32_t width = 0, height = 0;
  std::vector<CloudField> fields = {};
  bool is_big_endian = false;
  std::uint32_t point_step = 0, row_step = 0;  ///< bytes
  std::span<const std::byte> data = {};

  /// Rows of points, as a camera's picture has rows of pixels.
  [[nodiscard]] bool has_rows() const { return height > 1 && width > 1; }

  /// A field of that name, of one of these types, with one element that lies within a point; null: there is none.
  [[nodiscard]] const CloudField* find(std::string_view name, std::initializer_list<CloudType> types) const;

  /// False: `data` is too short for width x height points, or rows overlap.
  [[nodiscard]] bool has_all_points() const;

  /// The value of a field that find() gave. `point`: the offset of the point in `data`. T is of the field's size.
  template <typename T>
  [[nodiscard]] T value(const CloudField& field, std::size_t point) const {
    ByteReader reader(data.subspan(point + field.offset, sizeof(T)));
    return (is_big_endian ? reader.big_endian<T>() : reader.little_endian<T>()).value_or(T{});
  }

  /// The value of a field of any type that find() gave.
  [[nodiscard]] double number(const CloudField& field, std::size_t point) const;

  /// Calls `take(point)` with the offset of each point, row by row. To be called where has_all_points().
  template <typename Take>
  void visit_points(Take take) const {
    for (std::uint32_t v = 0; v < height; ++v) {
      for (std::uint32_t u = 0; u < width; ++u) {
        take(std::size_t{v} * row_step + std::size_t{u} * point_step);
      }
    }
  }
};

/// Errors (kInput, without `where`): truncated, or more than 100 fields.
[[nodiscard]] Result<CloudMessage> parse_cloud_message(const RosMessage& message);

}  // namespace scanknit
