// A room whose walls are planes, as a turning LiDAR sees it: the distance of each ray is exact.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/pose.h"

namespace scanknit::test {

/// The inside of a box, 12 x 8 x 3 m. Its frame: x forward, y left, z up.
inline const Eigen::Vector3d kRoomLow(-6, -4, -1.2);
inline const Eigen::Vector3d kRoomHigh(6, 4, 1.8);

inline double ray_in_room_m(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) {
  double nearest = std::numeric_limits<double>::max();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double wall = direction[axis] > 0 ? kRoomHigh[axis] : kRoomLow[axis];
    nearest = std::min(nearest, (wall - from[axis]) / direction[axis]);
  }
  return nearest;
}

/// The distance of a point of the room's frame to the nearest wall.
inline double off_walls_m(const Eigen::Vector3d& p) {
  double off = std::numeric_limits<double>::max();
  for (int axis = 0; axis < 3; ++axis) {
    off = std::min({off, std::abs(p[axis] - kRoomLow[axis]), std::abs(p[axis] - kRoomHigh[axis])});
  }
  return off;
}

/// The scanner.
struct LidarModel {
  int rings = 32;
  double lowest_deg = -40, highest_deg = 40;
  int columns = 900;

  /// Unit, the sensor's frame; ring 0 is the highest.
  [[nodiscard]] Eigen::Vector3d direction(int ring, int column) const {
    const double elevation = (highest_deg - (highest_deg - lowest_deg) * ring / (rings - 1)) * std::numbers::pi / 180;
    const double azimuth = 2 * std::numbers::pi * (column + 0.5) / columns;
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
  }
};

/// The walk of the sensor through the room.
inline Pose sensor_at(double fraction) {
  Pose T_room_sensor = Pose::Identity();
  T_room_sensor.translation() = Eigen::Vector3d(-3 + 6 * fraction, 1.5 * std::sin(3 * fraction), 0.2 * fraction);
  T_room_sensor.linear() = Eigen::AngleAxisd(0.4 * fraction, Eigen::Vector3d(0.1, 0.05, 1).normalized()).matrix();
  return T_room_sensor;
}

/// Points in the sensor's frame, ring by ring.
inline std::vector<Eigen::Vector3f> sweep_of_room(const LidarModel& model, const Pose& T_room_sensor) {
  std::vector<Eigen::Vector3f> points;
  for (int ring = 0; ring < model.rings; ++ring) {
    for (int column = 0; column < model.columns; ++column) {
      const Eigen::Vector3d direction = model.direction(ring, column);
      const double range = ray_in_room_m(T_room_sensor.translation(), T_room_sensor.linear() * direction);
      points.push_back((direction * range).cast<float>());
    }
  }
  return points;
}

/// From the sensor's frame to that of KITTI's left camera: x right, y down, z forward.
inline Pose kitti_camera_of_sensor() {
  Pose T_camera_sensor = Pose::Identity();
  T_camera_sensor.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T_camera_sensor.rotate(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitY()));
  T_camera_sensor.translation() = Eigen::Vector3d(0.1, -0.4, -0.3);
  return T_camera_sensor;
}

inline std::string twelve_numbers(const Pose& pose) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      char number[32];
      std::snprintf(number, sizeof number, "%.9e", pose.matrix()(row, column));
      text += (text.empty() ? "" : " ") + std::string(number);
    }
  }
  return text;
}

inline std::string kitti_bytes(const std::vector<Eigen::Vector3f>& points) {
  std::string bytes;
  for (const Eigen::Vector3f& p : points) {
    for (const float value : {p.x(), p.y(), p.z(), 0.5F}) {
      const auto bits = std::bit_cast<std::uint32_t>(value);
      for (unsigned shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(bits >> shift & 0xff);
    }
  }
  return bytes;
}

/// A sequence of KITTI's odometry benchmark. Its world is the camera's frame where the sensor is at the room's origin.
inline void write_kitti_room(const std::filesystem::path& folder, int sweeps, const LidarModel& model = {}) {
  std::filesystem::create_directories(folder / "velodyne");
  const Pose T_camera_sensor = kitti_camera_of_sensor();
  std::ofstream poses(folder / "poses.txt"), times(folder / "times.txt");
  for (int i = 0; i < sweeps; ++i) {
    const Pose T_room_sensor = sensor_at(sweeps == 1 ? 0 : static_cast<double>(i) / (sweeps - 1));
    const std::string digits = std::to_string(i);
    const std::string name = std::string(6 - digits.size(), '0') + digits + ".bin";
    std::ofstream(folder / "velodyne" / name, std::ios::binary) << kitti_bytes(sweep_of_room(model, T_room_sensor));
    poses << twelve_numbers(T_camera_sensor * T_room_sensor * T_camera_sensor.inverse()) << "\n";
    times << i * 0.1 << "\n";
  }
  std::ofstream(folder / "calib.txt") << "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nTr: " << twelve_numbers(T_camera_sensor)
                                      << "\n";
}

}  // namespace scanknit::test
