// The UDP datagrams of a network capture (.pcap, .pcapng), one after the other. Only a part of the file is in memory.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/result.h"

namespace scanknit {

/// True for the first bytes of a capture.
[[nodiscard]] bool is_pcap(std::span<const std::byte> first_bytes);

/// True for a file that begins as a capture does.
[[nodiscard]] bool is_pcap_file(const std::filesystem::path& path);

/// One record of a capture: what was seen on the wire.
struct PcapRecord {
  std::uint64_t offset = 0;  ///< in the file
  std::int64_t time_ns = 0;  ///< Unix time, >= 0
  std::uint16_t link_type = 0;
  std::span<const std::byte> bytes = {};  ///< valid until the next call
};

/// The records of a capture: the classic format of libpcap in both byte orders, with microseconds or nanoseconds
/// (draft-ietf-opsawg-pcap), and pcapng (draft-ietf-opsawg-pcapng).
class PcapRecords {
 public:
  /// Errors (kInput, without `where`): no capture.
  [[nodiscard]] static Result<PcapRecords> open(std::unique_ptr<RandomAccess> file);

  /// Nothing at the end, and where the file is damaged.
  [[nodiscard]] std::optional<PcapRecord> next();

  /// `offset`: PcapRecord::offset of a record that was read before.
  void seek(std::uint64_t offset) { position_ = offset; }

  /// Where reading ended too early, and why; empty: nowhere.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  struct Interface {
    std::uint16_t link_type = 0;
    std::uint64_t units_per_s = 1'000'000;
    std::int64_t offset_s = 0;
  };
  /// Of pcapng; the interfaces are numbered within it.
  struct Section {
    std::uint64_t offset = 0;
    bool is_big_endian = false;
    std::vector<Interface> interfaces = {};
    std::uint64_t interfaces_until = 0;  ///< where the last one was found
  };

  explicit PcapRecords(std::unique_ptr<RandomAccess> file) : file_(std::move(file)) {}
  [[nodiscard]] std::optional<std::span<const std::byte>> view(std::uint64_t offset, std::uint64_t size);
  [[nodiscard]] std::optional<PcapRecord> next_classic();
  [[nodiscard]] std::optional<PcapRecord> next_block();
  [[nodiscard]] std::optional<Section*> section_at(std::uint64_t offset, std::span<const std::byte> head);
  void read_interface(std::span<const std::byte> block, std::uint64_t offset, Section& section) const;
  std::nullopt_t end_damaged(const std::string& why);

  std::unique_ptr<RandomAccess> file_;
  std::vector<std::byte> window_;  ///< a part of the file
  std::uint64_t window_offset_ = 0;
  std::uint64_t position_ = 0;
  std::string damage_;
  bool is_pcapng_ = false;
  bool is_big_endian_ = false, has_ns_ = false;  ///< of the classic format
  std::uint16_t link_type_ = 0;                  ///< of the classic format
  std::vector<Section> sections_;                ///< of pcapng, as they were met
};

struct UdpDatagram {
  std::uint64_t offset = 0;                 ///< of its first record
  std::int64_t time_ns = 0;                 ///< when it was captured, Unix time, >= 0
  std::uint32_t source = 0;                 ///< IPv4 address
  std::uint16_t port = 0;                   ///< of the destination
  std::span<const std::byte> payload = {};  ///< valid until the next call
};

/// The datagrams of IPv4 in a capture of Ethernet (with VLAN tags), of Linux' "any" device (SLL, SLL2), or of raw IP.
/// Fragments are put together again.
class UdpDatagrams {
 public:
  explicit UdpDatagrams(PcapRecords records) : records_(std::move(records)) {}

  /// Nothing at the end, and where the file is damaged.
  [[nodiscard]] std::optional<UdpDatagram> next();

  /// `offset`: UdpDatagram::offset of a datagram that was read before.
  void seek(std::uint64_t offset);

  [[nodiscard]] const PcapRecords& records() const { return records_; }
  [[nodiscard]] std::uint64_t cut_short() const { return cut_short_; }    ///< captured in part only
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }  ///< some of their fragments are missing

 private:
  static constexpr std::size_t kMostBytes = 1U << 16;  ///< of a datagram
  static constexpr std::size_t kUnit = 8;              ///< fragments begin at multiples of it

  /// A datagram of which some fragments came.
  struct Pending {
    std::uint64_t offset = 0;
    std::int64_t time_ns = 0;
    std::uint32_t source = 0, destination = 0;
    std::uint16_t id = 0;
    std::size_t size = 0;  ///< 0: the last fragment is missing
    std::vector<std::byte> bytes = {};
    std::bitset<kMostBytes / kUnit> has_unit = {};
  };

  [[nodiscard]] std::optional<UdpDatagram> from_ip(const PcapRecord& record, std::span<const std::byte> packet);
  [[nodiscard]] std::optional<UdpDatagram> from_fragment(Pending fragment, std::size_t at, bool is_last,
                                                         std::span<const std::byte> bytes);
  [[nodiscard]] std::optional<UdpDatagram> from_udp(const Pending& origin, std::span<const std::byte> bytes);

  PcapRecords records_;
  std::vector<Pending> pending_;  ///< the oldest first
  std::vector<std::byte> whole_;  ///< the datagram that was put together last
  std::uint64_t cut_short_ = 0, incomplete_ = 0;
};

}  // namespace scanknit
