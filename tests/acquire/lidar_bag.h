// A bag of ROS of a LiDAR that is carried through a room (lidar_room.h) while it turns.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tests/acquire/lidar_room.h"
#include "tests/acquire/ros2_bag.h"

namespace scanknit::test {

/// sensor_msgs/PointField's numbers.
constexpr std::uint8_t kUint8Field = 2, kUint16Field = 4, kUint32Field = 6, kFloat32Field = 7, kFloat64Field = 8;

/// How a driver writes its clouds.
struct CloudFormat {
  std::string_view time_name = "time";  ///< empty: points have no times
  std::uint8_t time_type = kFloat32Field;
  double time_units_per_s = 1;          ///< 1: seconds; 1e9: nanoseconds
  bool is_time_absolute = false;        ///< since the epoch; else after the stamp
  bool is_stamp_at_end = false;         ///< of the turn; else at its begin
  std::string_view ring_name = "ring";  ///< empty: none
  std::uint8_t ring_type = kUint16Field;
  std::uint8_t place_type = kFloat32Field;
  bool has_rows = false;  ///< a row for each laser; else one list
  bool is_big_endian = false;
};

inline void append_number(Bytes& data, double value, std::uint8_t type, bool is_big_endian) {
  const std::size_t begin = data.size();
  ByteAppender writer(data);
  if (type == kUint8Field) writer.little_endian(static_cast<std::uint8_t>(value));
  if (type == kUint16Field) writer.little_endian(static_cast<std::uint16_t>(value));
  if (type == kUint32Field) writer.little_endian(static_cast<std::uint32_t>(value));
  if (type == kFloat32Field) writer.little_endian(static_cast<float>(value));
  if (type == kFloat64Field) writer.little_endian(value);
  if (is_big_endian) std::reverse(data.begin() + static_cast<std::ptrdiff_t>(begin), data.end());
}

inline std::uint32_t bytes_of_field(std::uint8_t type) {
  return type == kUint8Field ? 1 : type == kUint16Field ? 2 : type == kFloat64Field ? 8 : 4;
}

struct TimedPoint {
  Eigen::Vector3f p_sensor = {};
  int ring = 0;
  std::int64_t time_ns = 0;
};

/// sensor_msgs/PointCloud2. Rows, where there are any, are padded.
inline Bytes cloud_of_points(const Ros2Writer& ros, const CloudFormat& format, std::int64_t stamp_ns,
                             std::string_view frame, const std::vector<TimedPoint>& points, std::uint32_t height) {
  struct Field {
    std::string_view name;
    std::uint8_t type = 0;
  };
  std::vector<Field> fields = {{"x", format.place_type}, {"y", format.place_type}, {"z", format.place_type}};
  fields.push_back({"intensity", kFloat32Field});
  if (!format.ring_name.empty()) fields.push_back({format.ring_name, format.ring_type});
  if (!format.time_name.empty()) fields.push_back({format.time_name, format.time_type});
  const auto width = static_cast<std::uint32_t>(points.size()) / height;
  CdrWriter writer = ros.begin(stamp_ns, frame).number(height).number(width);
  writer.number(static_cast<std::uint32_t>(fields.size()));
  std::uint32_t step = 0;
  for (const Field& field : fields) {
    writer.text(field.name).number(step).number(field.type).number(std::uint32_t{1});
    step += bytes_of_field(field.type);
  }
  const std::uint32_t row_step = step * width + (height > 1 ? 5 : 0);
  writer.number(static_cast<std::uint8_t>(format.is_big_endian)).number(step).number(row_step);
  Bytes data;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TimedPoint& point = points[i];
    const auto add = [&](double value, std::uint8_t type) { append_number(data, value, type, format.is_big_endian); };
    for (const float value : point.p_sensor) add(value, format.place_type);
    add(0.5, kFloat32Field);
    if (!format.ring_name.empty()) add(point.ring, format.ring_type);
    const double since_ns = static_cast<double>(format.is_time_absolute ? point.time_ns : point.time_ns - stamp_ns);
    if (!format.time_name.empty()) add(since_ns * 1e-9 * format.time_units_per_s, format.time_type);
    if ((i + 1) % width == 0) data.resize(row_step * ((i + 1) / width));
  }
  return writer.sequence(data).number(std::uint8_t{1}).bytes();
}

/// The walk: three seconds through the room.
struct LidarWalk {
  static constexpr std::int64_t kBegin_ns = 1'700'000'000'000'000'000, kTurn_ns = 100'000'000;
  static constexpr std::int64_t kBeyond_ns = 50'000'000;  ///< tf begins so much before and ends so much later

  LidarModel model = {.rings = 8, .columns = 180};
  Ros2Writer ros = {};
  CloudFormat format = {};
  int sweeps = 4;
  std::int64_t tf_step_ns = 10'000'000;
  std::int64_t tf_beyond_ns = kBeyond_ns;

  /// Where the body is, and the LiDAR on it.
  [[nodiscard]] static Pose body_at(std::int64_t time_ns) {
    return sensor_at(static_cast<double>(time_ns - kBegin_ns) / 3e9);
  }
  [[nodiscard]] static Pose T_body_lidar() {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(0.2, -0.1, 0.3);
    pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, 0.2, 1).normalized()).matrix();
    return pose;
  }
  [[nodiscard]] static Pose lidar_at(std::int64_t time_ns) { return body_at(time_ns) * T_body_lidar(); }
  [[nodiscard]] static std::vector<double> numbers_of(const Pose& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d p = pose.translation();
    return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
  }

  [[nodiscard]] std::int64_t end_ns() const { return kBegin_ns + kTurn_ns * sweeps; }
  [[nodiscard]] std::int64_t stamp_ns(int sweep) const {
    return kBegin_ns + kTurn_ns * (sweep + (format.is_stamp_at_end ? 1 : 0));
  }

  /// Ring by ring. The last point of the first ring has no return, and is at the sensor.
  [[nodiscard]] std::vector<TimedPoint> points_of(int sweep) const {
    std::vector<TimedPoint> points;
    for (int ring = 0; ring < model.rings; ++ring) {
      for (int column = 0; column < model.columns; ++column) {
        const std::int64_t time_ns = kBegin_ns + kTurn_ns * sweep + kTurn_ns * column / model.columns;
        const Pose T_room_lidar = lidar_at(time_ns);
        const Eigen::Vector3d direction = model.direction(ring, column);
        const double range = ray_in_room_m(T_room_lidar.translation(), T_room_lidar.linear() * direction);
        const bool has_return = ring > 0 || column + 1 < model.columns;
        points.push_back(
            {has_return ? Eigen::Vector3f((direction * range).cast<float>()) : Eigen::Vector3f::Zero(), ring, time_ns});
      }
    }
    return points;
  }

  void add_tf(Ros2Bag& bag) const {
    bag.add("/tf_static", kTransformType, kBegin_ns, ros.transform(0, "body", "lidar", numbers_of(T_body_lidar())));
    for (std::int64_t time = kBegin_ns - tf_beyond_ns; time <= end_ns() + tf_beyond_ns; time += tf_step_ns) {
      bag.add("/tf", kTransformType, time, ros.transform(time, "map", "body", numbers_of(body_at(time))));
    }
  }
  void add_clouds(Ros2Bag& bag, const std::string& topic = "/points") const {
    const auto height = format.has_rows ? static_cast<std::uint32_t>(model.rings) : 1U;
    for (int i = 0; i < sweeps; ++i) {
      bag.add(topic, kCloudType, stamp_ns(i) + 7,
              cloud_of_points(ros, format, stamp_ns(i), "lidar", points_of(i), height));
    }
  }
  [[nodiscard]] Ros2Bag bag() const {
    Ros2Bag bag;
    add_tf(bag);
    add_clouds(bag);
    return bag;
  }
};

}  // namespace scanknit::test
