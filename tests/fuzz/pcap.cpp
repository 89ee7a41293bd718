// Captures of LiDARs; the first byte chooses: a whole capture, a Velodyne's packet, an Ouster's packet, its metadata.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "acquire/lidar/ouster_packets.h"
#include "acquire/lidar/pcap_file.h"
#include "acquire/lidar/pcap_sweeps.h"
#include "acquire/lidar/velodyne_packets.h"

namespace {

using Bytes = std::span<const std::byte>;

constexpr std::string_view kMetadata =
    R"({"beam_altitude_angles": [10, 3, -3, -10], "beam_azimuth_angles": [3, 1, -1, -3],
  "data_format": {"columns_per_frame": 16, "columns_per_packet": 8, "pixels_per_column": 4,
  "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16"}, "lidar_mode": "16x10"})";

void decode(scanknit::LidarPackets& packets, Bytes packet) {
  if (!packets.fits(packet)) return;
  const auto head = packets.head(packet);
  scanknit::Sweep sweep;
  const std::size_t first = head ? head->turn_begins.value_or(0) : 0;
  packets.add_points(packet, {first, packets.blocks()}, head ? head->clock_ns % 1000 : 0, sweep);
}

void decode_velodyne(Bytes packet) {
  auto velodyne = scanknit::velodyne_of(packet);
  if (velodyne && *velodyne) decode(***velodyne, packet);
}

void decode_ouster(Bytes packet) {
  if (auto metadata = scanknit::parse_ouster_metadata(kMetadata)) {
    decode(*scanknit::ouster_packets(*std::move(metadata)), packet);
  }
}

void read_capture(Bytes file) {
  (void)scanknit::open_pcap_sweeps(std::make_unique<scanknit::MemoryAccess>(file), "/no_such_folder/a.pcap", {});
  auto records = scanknit::PcapRecords::open(std::make_unique<scanknit::MemoryAccess>(file));
  if (!records) return;
  scanknit::UdpDatagrams datagrams(*std::move(records));
  while (const auto datagram = datagrams.next()) {
    decode_velodyne(datagram->payload);
    decode_ouster(datagram->payload);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const auto content = std::as_bytes(std::span(bytes, size)).subspan(1);
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  switch (bytes[0] % 4) {
    case 0: read_capture(content); break;
    case 1: decode_velodyne(content); break;
    case 2: decode_ouster(content); break;
    default:
      if (auto metadata = scanknit::parse_ouster_metadata(text)) {
        decode(*scanknit::ouster_packets(*std::move(metadata)), content);
      }
      break;
  }
  return 0;
}
