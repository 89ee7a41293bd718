// The packets of Ouster's LiDARs, which need the sensor's metadata (JSON) to be understood.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/lidar/lidar_packets.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// How a packet is laid out (UDP profile).
struct OusterProfile {
  const char* name = "";
  std::size_t packet_header = 0, column_header = 0, pixel = 0, column_footer = 0, packet_footer = 0;  ///< bytes
  std::uint32_t range_mask = 0;  ///< of the bits of a range
  int range_unit_mm = 1;
  int returns = 1;  ///< in a pixel, one after the other, 4 bytes each
};

/// What the metadata says of the sensor.
struct OusterMetadata {
  const OusterProfile* profile = nullptr;
  std::string model;  ///< "OS-1-128"
  std::size_t columns_per_frame = 0, columns_per_packet = 0, pixels_per_column = 0;
  double frames_per_s = 0;                  ///< 0: unknown
  std::vector<double> altitudes, azimuths;  ///< of the beams, radians
  double beam_out_m = 0, beam_up_m = 0;     ///< of the beams' origin, from the lidar's
  Pose T_sensor_lidar = Pose::Identity();   ///< metres

  [[nodiscard]] std::size_t packet_bytes() const;
};

/// The metadata of firmware 1.12 to 3.1, flat or nested. Errors (kInput, without `where`): not such metadata; values
/// that cannot be; a UDP profile that is not read.
[[nodiscard]] Result<OusterMetadata> parse_ouster_metadata(std::string_view text);

[[nodiscard]] std::unique_ptr<LidarPackets> ouster_packets(OusterMetadata metadata);

}  // namespace scanknit
