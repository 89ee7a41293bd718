// LidarPackets: what the UDP packets of a kind of LiDAR mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "acquire/lidar/sweep_source.h"
#include "core/files/byte_reader.h"

namespace scanknit {

/// The number at a place of a packet; 0 where the packet is too short.
template <typename T>
[[nodiscard]] T little_endian_at(std::span<const std::byte> bytes, std::size_t at) {
  if (at > bytes.size()) return T{};
  return ByteReader(bytes.subspan(at)).little_endian<T>().value_or(T{});
}
template <typename T>
[[nodiscard]] T big_endian_at(std::span<const std::byte> bytes, std::size_t at) {
  if (at > bytes.size()) return T{};
  return ByteReader(bytes.subspan(at)).big_endian<T>().value_or(T{});
}

/// What a packet says of itself, without its points.
struct PacketHead {
  std::int64_t clock_ns = 0;  ///< the sensor's clock at the packet's first measurement, >= 0
  std::uint32_t turn = 0;     ///< the number of the turn, where the packets have one; else 0
  /// The first block of a new turn; nothing: the turn goes on.
  std::optional<std::size_t> turn_begins = {};
};

/// Blocks of a packet, measured at one azimuth each: first <= block < end.
struct PacketBlocks {
  std::size_t first = 0;
  std::size_t end = 0;
};

/// Reads the packets of one sensor. They come in the order in which they were sent, but some may be lost.
class LidarPackets {
 public:
  virtual ~LidarPackets() = default;

  [[nodiscard]] virtual std::string name() const = 0;  ///< "velodyne_vlp16"
  [[nodiscard]] virtual std::size_t blocks() const = 0;
  [[nodiscard]] virtual std::int64_t clock_period_ns() const = 0;  ///< the clock begins anew after it; 0: never
  [[nodiscard]] virtual std::int64_t duration_ns() const = 0;      ///< of a packet, about; 0: unknown

  /// True for a packet with points of this sensor.
  [[nodiscard]] virtual bool fits(std::span<const std::byte> packet) const = 0;

  /// Of a packet that fits; compares it with the one before. Nothing: it holds no measurement.
  [[nodiscard]] virtual std::optional<PacketHead> head(std::span<const std::byte> packet) = 0;

  /// Adds the points of a packet that fits to the sweep, with their rings and times. `offset_ns`: the packet's first
  /// measurement after Sweep::timestamp_ns.
  virtual void add_points(std::span<const std::byte> packet, PacketBlocks blocks, std::int64_t offset_ns,
                          Sweep& sweep) const = 0;
};

}  // namespace scanknit
