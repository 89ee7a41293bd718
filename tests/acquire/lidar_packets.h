// Captures of turning LiDARs in the room of lidar_room.h, written by the manuals' formulas (Velodyne VLP-16 63-9243,
// VLP-32C 63-9325, HDL-32E 63-9113; Ouster's sensor documentation), apart from what reads them.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lidar_room.h"

namespace scanknit::test {

// Bytes in either order.
inline std::string number_bytes(std::uint64_t value, int count, bool is_big_endian = false) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    const int shift = 8 * (is_big_endian ? count - 1 - i : i);
    bytes += static_cast<char>(value >> shift & 0xff);
  }
  return bytes;
}

/// A walk of 2 m/s along x with a turn of half a radian a second; poses between two of it are exactly interpolated.
inline Pose walk_at(double since_s) {
  Pose T_room_sensor = Pose::Identity();
  T_room_sensor.translation() = Eigen::Vector3d(-3 + 2 * since_s, 0.5 - 0.6 * since_s, 0.1);
  T_room_sensor.linear() = Eigen::AngleAxisd(0.5 * since_s, Eigen::Vector3d(0.05, 0.02, 1).normalized()).matrix();
  return T_room_sensor;
}

/// Lines of the TUM format from `before_s` before the walk begins.
inline void write_walk(const std::filesystem::path& file, double began_s, double before_s = 0.1, double long_s = 2) {
  std::ofstream poses(file);
  for (int i = 0; i * 0.05 <= long_s; ++i) {
    const double since_s = i * 0.05 - before_s;
    const Pose pose = walk_at(since_s);
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d p = pose.translation();
    char line[256];
    std::snprintf(line, sizeof line, "%.6f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", began_s + since_s, p.x(), p.y(),
                  p.z(), q.x(), q.y(), q.z(), q.w());
    poses << line;
  }
}

/// A UDP packet on its way.
struct SentPacket {
  double since_s = 0;  ///< of the walk, when it is complete
  std::string payload;
  std::uint16_t port = 2368;
};

/// What a beam that begins at `origin`, both in the sensor's frame, measures.
inline double measured_m(double since_s, const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Pose T_room_sensor = walk_at(since_s);
  return ray_in_room_m(T_room_sensor * origin, T_room_sensor.linear() * ray);
}

// --- Velodyne ---

struct WrittenVelodyne {
  std::uint8_t product = 0x22;
  int lasers = 16;
  double unit_m = 0.002;
  double shot_us = 2.304, cycle_us = 55.296;
  bool fires_pairs = false;
  int step = 40;  ///< hundredths of a degree that a block turns
  bool is_dual = false;

  static WrittenVelodyne vlp16() { return {}; }
  static WrittenVelodyne vlp32c() { return {0x28, 32, 0.004, 2.304, 55.296, true, 20, false}; }
  static WrittenVelodyne hdl32e() { return {0x21, 32, 0.002, 1.152, 46.08, false, 17, false}; }

  [[nodiscard]] double elevation_deg(int laser) const {
    static const double vlp32c[32] = {-25,    -1,    -1.667, -15.639, -11.31, 0,     -0.667, -8.843,
                                      -7.254, 0.333, -0.333, -6.148,  -5.333, 1.333, 0.667,  -4,
                                      -4.667, 1.667, 1,      -3.667,  -3.333, 3.333, 2.333,  -2.667,
                                      -3,     7,     4.667,  -2.333,  -2,     15,    10.333, -1.333};
    static const double hdl32e[32] = {-30.67, -9.33, -29.33, -8, -28, -6.67, -26.67, -5.33, -25.33, -4, -24, -2.67,
                                      -22.67, -1.33, -21.33, 0,  -20, 1.33,  -18.67, 2.67,  -17.33, 4,  -16, 5.33,
                                      -14.67, 6.67,  -13.33, 8,  -12, 9.33,  -10.67, 10.67};
    if (product == 0x28) return vlp32c[laser];
    if (product == 0x21) return std::round(hdl32e[laser] * 3) / 3;  // printed with two decimals, steps are 4/3
    return laser % 2 == 0 ? laser - 15 : laser;                     // -15 1 -13 3 ... 15
  }
  [[nodiscard]] double azimuth_offset_deg(int laser) const {
    static const double vlp32c[32] = {1.4,  -4.2, 1.4,  -1.4, 1.4,  -1.4, 4.2,  -1.4, 1.4,  -4.2, 1.4,
                                      -1.4, 4.2,  -1.4, 4.2,  -1.4, 1.4,  -4.2, 1.4,  -4.2, 4.2,  -1.4,
                                      1.4,  -1.4, 1.4,  -1.4, 1.4,  -4.2, 4.2,  -1.4, 1.4,  -1.4};
    return product == 0x28 ? vlp32c[laser] : 0;
  }
  [[nodiscard]] double rise_m(int laser) const {
    static const double vlp16[16] = {11.2, -0.7, 9.7, -2.2, 8.1, -3.7, 6.6, -5.1,
                                     5.1,  -6.6, 3.7, -8.1, 2.2, -9.7, 0.7, -11.2};
    return product == 0x22 ? vlp16[laser] * 0.001 : 0;
  }
  [[nodiscard]] double block_us() const { return cycle_us * (32 / lasers); }
  [[nodiscard]] int firings() const { return is_dual ? 6 : 12; }  ///< blocks of a packet at different times
  [[nodiscard]] double packet_us() const { return block_us() * firings(); }
};

/// In units; x of the manual is right, y forward.
inline unsigned velodyne_distance(const WrittenVelodyne& model, int laser, double azimuth_deg, double since_s) {
  const double a = (azimuth_deg + model.azimuth_offset_deg(laser)) * std::numbers::pi / 180;
  const double w = model.elevation_deg(laser) * std::numbers::pi / 180;
  const Eigen::Vector3d manual(std::cos(w) * std::sin(a), std::cos(w) * std::cos(a), std::sin(w));
  const Eigen::Vector3d ray(manual.y(), -manual.x(), manual.z());
  return static_cast<unsigned>(std::lround(measured_m(since_s, {0, 0, model.rise_m(laser)}, ray) / model.unit_m));
}

/// `clock_s`: the sensor's clock where the walk begins, seconds; it counts the microseconds of the hour. `first_step`:
/// azimuth of the first block, in steps.
inline std::vector<SentPacket> velodyne_packets(const WrittenVelodyne& model, int count, double clock_s,
                                                int first_step = 0) {
  std::vector<SentPacket> packets;
  for (int i = 0; i < count; ++i) {
    // The packet's time has whole microseconds; what is measured is measured then.
    const double began_us = std::round(i * model.packet_us());
    std::string bytes;
    for (int block = 0; block < 12; ++block) {
      const int firing = model.is_dual ? block / 2 : block;
      const int azimuth = (first_step + i * model.firings() + firing) * model.step % 36000;
      bytes += "\xff\xee" + number_bytes(static_cast<unsigned>(azimuth), 2);
      for (int index = 0; index < 32; ++index) {
        const int laser = index % model.lasers;
        const int slot = model.fires_pairs ? laser / 2 : laser;
        const double after_us = (index / model.lasers) * model.cycle_us + slot * model.shot_us;
        const double since_s = (began_us + firing * model.block_us() + after_us) * 1e-6;
        const double turned_deg = 0.01 * (azimuth + model.step * after_us / model.block_us());
        unsigned distance = velodyne_distance(model, laser, turned_deg, since_s);
        if (model.is_dual && block % 2 == 1 && laser % 2 == 0) distance /= 2;  // something half transparent
        bytes += number_bytes(distance, 2) + '\x20';
      }
    }
    const double clock_us = std::fmod(std::round(clock_s * 1e6) + began_us, 3'600e6);
    bytes += number_bytes(static_cast<std::uint64_t>(clock_us), 4);
    bytes += static_cast<char>(model.is_dual ? 0x39 : 0x37);
    bytes += static_cast<char>(model.product);
    packets.push_back({(began_us + model.packet_us()) * 1e-6, bytes});
  }
  return packets;
}

// --- Ouster ---

struct WrittenOuster {
  std::string profile = "LEGACY";
  int beams = 64;
  int columns = 512, in_packet = 16;
  int turns_per_s = 10;
  double beam_out_mm = 15.806;
  bool is_nested = false;

  [[nodiscard]] double altitude_deg(int beam) const { return 16.6 - 33.2 * beam / (beams - 1); }
  [[nodiscard]] double azimuth_deg(int beam) const { return 3.1 - 2.05 * (beam % 4); }

  [[nodiscard]] std::string json() const {
    std::string altitudes, azimuths;
    for (int beam = 0; beam < beams; ++beam) {
      char number[64];
      std::snprintf(number, sizeof number, "%s%.12g", beam > 0 ? ", " : "", altitude_deg(beam));
      altitudes += number;
      std::snprintf(number, sizeof number, "%s%.12g", beam > 0 ? ", " : "", azimuth_deg(beam));
      azimuths += number;
    }
    const std::string beams_of = "\"beam_altitude_angles\": [" + altitudes + "], \"beam_azimuth_angles\": [" +
                                 azimuths + "], \"lidar_origin_to_beam_origin_mm\": " + std::to_string(beam_out_mm);
    const std::string format = "{\"columns_per_frame\": " + std::to_string(columns) +
                               ", \"columns_per_packet\": " + std::to_string(in_packet) +
                               ", \"pixels_per_column\": " + std::to_string(beams) + ", \"udp_profile_lidar\": \"" +
                               profile + "\"}";
    const std::string placement =
        "\"lidar_to_sensor_transform\": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1]";
    const std::string mode = "\"lidar_mode\": \"" + std::to_string(columns) + "x" + std::to_string(turns_per_s) + "\"";
    if (!is_nested) {
      return "{" + beams_of + ", \"data_format\": " + format + ", " + placement + ", " + mode +
             ", \"prod_line\": \"OS-1-64\"}";
    }
    return "{\"beam_intrinsics\": {" + beams_of + "}, \"lidar_data_format\": " + format + ", \"lidar_intrinsics\": {" +
           placement + "}, \"config_params\": {" + mode + "}, \"sensor_info\": {\"prod_line\": \"OS-1-64\"}}";
  }
};

/// In millimetres from the lidar's axis. The beam begins beam_out_mm from it, where the encoder points.
inline unsigned ouster_range_mm(const WrittenOuster& model, int beam, int column, double since_s) {
  const double encoder = 2 * std::numbers::pi * (1.0 - static_cast<double>(column) / model.columns);
  const double azimuth = encoder - model.azimuth_deg(beam) * std::numbers::pi / 180;
  const double altitude = model.altitude_deg(beam) * std::numbers::pi / 180;
  Pose T_sensor_lidar = Pose::Identity();
  T_sensor_lidar.linear().diagonal() = Eigen::Vector3d(-1, -1, 1);
  T_sensor_lidar.translation().z() = 0.03618;
  const Eigen::Vector3d origin = 0.001 * model.beam_out_mm * Eigen::Vector3d(std::cos(encoder), std::sin(encoder), 0);
  const Eigen::Vector3d ray(std::cos(altitude) * std::cos(azimuth), std::cos(altitude) * std::sin(azimuth),
                            std::sin(altitude));
  const double measured = measured_m(since_s, T_sensor_lidar * origin, T_sensor_lidar.linear() * ray);
  return static_cast<unsigned>(std::lround(1000 * measured + model.beam_out_mm));
}

/// `clock_s`: the sensor's clock where the walk begins.
inline std::vector<SentPacket> ouster_packets_of(const WrittenOuster& model, int frames, double clock_s) {
  const bool is_legacy = model.profile == "LEGACY", is_dual = model.profile.ends_with("_DUAL");
  const bool is_low = model.profile == "RNG15_RFL8_NIR8";
  std::vector<SentPacket> packets;
  for (int i = 0; i < frames * model.columns / model.in_packet; ++i) {
    std::string bytes;
    double since_s = 0;
    const int frame = 65535 + i * model.in_packet / model.columns;  // wraps after the first
    if (!is_legacy) bytes += number_bytes(1, 2) + number_bytes(static_cast<unsigned>(frame), 2) + std::string(28, '\0');
    for (int c = 0; c < model.in_packet; ++c) {
      const int place = i * model.in_packet + c;
      since_s = static_cast<double>(place) / (model.columns * model.turns_per_s);
      const auto stamp_ns = static_cast<std::uint64_t>(std::llround(clock_s * 1e3)) * 1'000'000 +
                            static_cast<std::uint64_t>(std::llround(since_s * 1e9));
      const int column = place % model.columns;
      bytes += number_bytes(stamp_ns, 8) + number_bytes(static_cast<unsigned>(column), 2);
      bytes += is_legacy ? number_bytes(static_cast<unsigned>(frame), 2) + number_bytes(0, 4) : number_bytes(1, 2);
      for (int beam = 0; beam < model.beams; ++beam) {
        const unsigned range_mm = ouster_range_mm(model, beam, column, since_s);
        if (is_low) {
          bytes += number_bytes((range_mm + 4) / 8, 2) + "\x20\x10";
        } else {
          bytes += number_bytes(range_mm | 0x20000000U, 4);  // bits above the range's are not its
          bytes += is_dual ? number_bytes(range_mm / 2, 4) + std::string(8, '\x07') : std::string(8, '\x07');
        }
      }
      if (is_legacy) bytes += std::string(4, '\xff');
    }
    if (!is_legacy) bytes += std::string(32, '\0');
    packets.push_back({since_s, bytes, 7502});
  }
  return packets;
}

// --- The capture ---

struct WrittenCapture {
  enum class Link { kEthernet, kVlan, kCooked, kCooked2, kRaw };
  bool is_pcapng = false, is_big_endian = false, has_ns = false;
  Link link = Link::kEthernet;
  std::size_t mtu = 65535;                                           ///< larger packets are sent in fragments
  std::function<bool(int record)> keeps = [](int) { return true; };  ///< which records the capture has
};

inline std::string udp_bytes(const SentPacket& packet) {
  return number_bytes(packet.port, 2, true) + number_bytes(packet.port, 2, true) +
         number_bytes(packet.payload.size() + 8, 2, true) + number_bytes(0, 2) + packet.payload;
}

/// The IP packets of a datagram.
inline std::vector<std::string> ip_packets(const std::string& datagram, unsigned id, std::size_t mtu) {
  std::vector<std::string> packets;
  const std::size_t most = (mtu - 20) / 8 * 8;
  for (std::size_t at = 0; at < datagram.size(); at += most) {
    const std::string part = datagram.substr(at, most);
    const std::uint64_t more = at + part.size() < datagram.size() ? 0x2000 : 0;
    packets.push_back("\x45" + std::string(1, '\0') + number_bytes(20 + part.size(), 2, true) +
                      number_bytes(id, 2, true) + number_bytes(more | at / 8, 2, true) + "\x40\x11" +
                      std::string(2, '\0') + "\xc0\xa8\x01\xc9" + "\xc0\xa8\x01\x4d" + part);
  }
  return packets;
}

inline std::string framed(const std::string& ip, WrittenCapture::Link link) {
  const std::string type = number_bytes(0x0800, 2, true);
  switch (link) {
    case WrittenCapture::Link::kEthernet: return std::string(12, '\x01') + type + ip;
    case WrittenCapture::Link::kVlan: return std::string(12, '\x01') + number_bytes(0x81000005, 4, true) + type + ip;
    case WrittenCapture::Link::kCooked: return std::string(14, '\0') + type + ip;
    case WrittenCapture::Link::kCooked2: return type + std::string(18, '\0') + ip;
    default: return ip;
  }
}

inline unsigned link_number(WrittenCapture::Link link) {
  switch (link) {
    case WrittenCapture::Link::kCooked: return 113;
    case WrittenCapture::Link::kCooked2: return 276;
    case WrittenCapture::Link::kRaw: return 101;
    default: return 1;
  }
}

inline std::string pcapng_block(unsigned type, std::string body, bool big) {
  while (body.size() % 4 != 0) body += '\0';
  const std::string length = number_bytes(body.size() + 12, 4, big);
  return number_bytes(type, 4, big) + length + body + length;
}

/// `began_s`: the computer's clock where the walk begins.
inline std::string capture_bytes(const std::vector<SentPacket>& packets, double began_s,
                                 const WrittenCapture& form = {}) {
  const bool big = form.is_big_endian;
  std::string bytes;
  if (form.is_pcapng) {
    bytes += pcapng_block(
        0x0a0d0d0a,
        number_bytes(0x1a2b3c4d, 4, big) + number_bytes(1, 2, big) + number_bytes(0, 2) + std::string(8, '\xff'), big);
    std::string interface = number_bytes(link_number(form.link), 2, big) + number_bytes(0, 6);
    if (form.has_ns) interface += number_bytes(9, 2, big) + number_bytes(1, 2, big) + "\x09" + std::string(7, '\0');
    bytes += pcapng_block(1, interface, big);
  } else {
    bytes += number_bytes(form.has_ns ? 0xa1b23c4d : 0xa1b2c3d4, 4, big) + number_bytes(2, 2, big) +
             number_bytes(4, 2, big) + number_bytes(0, 8) + number_bytes(262144, 4, big) +
             number_bytes(link_number(form.link), 4, big);
  }
  int record = 0;
  unsigned id = 0;
  for (const SentPacket& packet : packets) {
    constexpr double kDelay_s = 0.0005;
    const auto time_us = static_cast<std::uint64_t>(std::llround((began_s + packet.since_s + kDelay_s) * 1e6));
    for (const std::string& ip : ip_packets(udp_bytes(packet), ++id, form.mtu)) {
      if (!form.keeps(record++)) continue;
      const std::string frame = framed(ip, form.link);
      const std::string sizes = number_bytes(frame.size(), 4, big) + number_bytes(frame.size(), 4, big);
      if (form.is_pcapng) {
        const std::uint64_t units = form.has_ns ? time_us * 1000 : time_us;
        bytes += pcapng_block(6,
                              number_bytes(0, 4) + number_bytes(units >> 32, 4, big) +
                                  number_bytes(units & 0xffffffff, 4, big) + sizes + frame,
                              big);
      } else {
        bytes += number_bytes(time_us / 1'000'000, 4, big) +
                 number_bytes(time_us % 1'000'000 * (form.has_ns ? 1000 : 1), 4, big) + sizes + frame;
      }
    }
  }
  return bytes;
}

inline void write_whole(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

}  // namespace scanknit::test
