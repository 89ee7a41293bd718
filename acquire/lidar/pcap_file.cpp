#include "acquire/lidar/pcap_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "acquire/lidar/lidar_packets.h"

namespace scanknit {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint64_t kWindowBytes = 1U << 20;
constexpr std::uint32_t kMostRecordBytes = 256U << 10;  // libpcap's largest snapshot
constexpr std::uint32_t kMicroseconds = 0xa1b2c3d4, kNanoseconds = 0xa1b23c4d;
constexpr std::size_t kClassicHeader = 24, kRecordHeader = 16;
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr std::int64_t kLatest_s = 0xffffffff;  // the classic format has 32 bits for it

// Blocks of pcapng (draft-ietf-opsawg-pcapng, section 4).
constexpr std::uint32_t kSectionBlock = 0x0a0d0d0a, kInterfaceBlock = 1, kOldPacketBlock = 2, kPacketBlock = 6;
constexpr std::uint32_t kByteOrder = 0x1a2b3c4d;
constexpr std::size_t kMostSections = 1000, kMostInterfaces = 1000;

template <typename T>
T number_at(Bytes bytes, std::size_t at, bool is_big_endian) {
  return is_big_endian ? big_endian_at<T>(bytes, at) : little_endian_at<T>(bytes, at);
}

bool is_pcapng(Bytes bytes) {
  const auto order = little_endian_at<std::uint32_t>(bytes, 8);
  return little_endian_at<std::uint32_t>(bytes, 0) == kSectionBlock &&
         (order == kByteOrder || big_endian_at<std::uint32_t>(bytes, 8) == kByteOrder);
}

/// The option if_tsresol: a power of 10, or with the highest bit of 2. The common 10^-6 where it is beyond reason.
std::uint64_t units_per_s(std::uint8_t resolution) {
  constexpr unsigned kBinary = 0x80, kMostBits = 60, kMostDigits = 18;
  const unsigned power = resolution & 0x7fU;
  if ((resolution & kBinary) != 0) return power <= kMostBits ? std::uint64_t{1} << power : 1'000'000;
  if (power > kMostDigits) return 1'000'000;
  std::uint64_t units = 1;
  for (unsigned i = 0; i < power; ++i) units *= 10;
  return units;
}

/// Unix time; 0 where it is beyond reason.
std::int64_t time_ns_of(std::uint64_t units, std::uint64_t per_s, std::int64_t offset_s) {
  const std::uint64_t seconds = units / per_s, rest = units % per_s;
  if (seconds > static_cast<std::uint64_t>(kLatest_s) || offset_s > kLatest_s || offset_s < -kLatest_s) return 0;
  const std::int64_t whole_s = static_cast<std::int64_t>(seconds) + offset_s;
  if (whole_s < 0 || whole_s > kLatest_s) return 0;
  constexpr std::uint64_t kNs = kNsPerSecond;
  const std::uint64_t ns = per_s <= kNs ? rest * kNs / per_s : rest / (per_s / kNs);
  return whole_s * kNsPerSecond + static_cast<std::int64_t>(std::min(ns, kNs - 1));
}

// Types of links (www.tcpdump.org/linktypes.html) and Ethernet's types.
constexpr std::uint16_t kEthernet = 1, kCooked = 113, kCooked2 = 276;
constexpr std::array<std::uint16_t, 4> kRawIp = {101, 228, 12, 14};
constexpr std::uint16_t kIpv4 = 0x0800;
constexpr std::array<std::uint16_t, 3> kVlan = {0x8100, 0x88a8, 0x9100};

/// The IPv4 packet in a frame; empty: it holds none.
Bytes ipv4_of(std::uint16_t link_type, Bytes frame) {
  std::size_t type_at = 0, at = 0;
  if (std::find(kRawIp.begin(), kRawIp.end(), link_type) != kRawIp.end()) return frame;
  if (link_type == kEthernet) {
    constexpr int kMostVlans = 4;
    type_at = 12;
    for (int tag = 0; tag < kMostVlans; ++tag) {
      const auto type = big_endian_at<std::uint16_t>(frame, type_at);
      if (std::find(kVlan.begin(), kVlan.end(), type) == kVlan.end()) break;
      type_at += 4;
    }
    at = type_at + 2;
  } else if (link_type == kCooked) {
    type_at = 14;
    at = 16;
  } else if (link_type == kCooked2) {
    at = 20;
  } else {
    return {};
  }
  if (at >= frame.size() || big_endian_at<std::uint16_t>(frame, type_at) != kIpv4) return {};
  return frame.subspan(at);
}

}  // namespace

bool is_pcap(Bytes first_bytes) {
  const auto little = little_endian_at<std::uint32_t>(first_bytes, 0);
  const auto big = big_endian_at<std::uint32_t>(first_bytes, 0);
  return little == kMicroseconds || little == kNanoseconds || big == kMicroseconds || big == kNanoseconds ||
         is_pcapng(first_bytes);
}

bool is_pcap_file(const std::filesystem::path& path) {
  const auto file = open_random_access(path);
  if (!file) return false;
  std::array<std::byte, 12> first{};
  return (*file)->read(0, first) && is_pcap(first);
}

Result<PcapRecords> PcapRecords::open(std::unique_ptr<RandomAccess> file) {
  PcapRecords records(std::move(file));
  const auto head = records.view(0, std::min<std::uint64_t>(kClassicHeader, records.file_->size()));
  if (!head || !is_pcap(*head) || head->size() < kClassicHeader) {
    return Error{ErrorCode::kInput, "no capture of a network: expected a .pcap or .pcapng file"};
  }
  records.is_pcapng_ = is_pcapng(*head);
  if (records.is_pcapng_) return records;
  const auto little = little_endian_at<std::uint32_t>(*head, 0), big = big_endian_at<std::uint32_t>(*head, 0);
  records.is_big_endian_ = big == kMicroseconds || big == kNanoseconds;
  records.has_ns_ = (records.is_big_endian_ ? big : little) == kNanoseconds;
  // Of its 32 bits the upper ones tell of a check sum at the end of the frames.
  records.link_type_ = static_cast<std::uint16_t>(number_at<std::uint32_t>(*head, 20, records.is_big_endian_) & 0xffff);
  records.position_ = kClassicHeader;
  return records;
}

std::optional<Bytes> PcapRecords::view(std::uint64_t offset, std::uint64_t size) {
  const std::uint64_t end = file_->size();
  if (offset > end || size > end - offset || size > kWindowBytes) return std::nullopt;
  const bool is_inside = offset >= window_offset_ && offset - window_offset_ <= window_.size() &&
                         size <= window_.size() - (offset - window_offset_);
  if (!is_inside) {
    window_.resize(static_cast<std::size_t>(std::min(kWindowBytes, end - offset)));
    window_offset_ = offset;
    if (!file_->read(offset, window_)) {
      window_.clear();
      return std::nullopt;
    }
  }
  return Bytes(window_).subspan(static_cast<std::size_t>(offset - window_offset_), static_cast<std::size_t>(size));
}

std::nullopt_t PcapRecords::end_damaged(const std::string& why) {
  damage_ = fmt::format("the capture ends at byte {} of {}: {}", position_, file_->size(), why);
  return std::nullopt;
}

std::optional<PcapRecord> PcapRecords::next() {
  return is_pcapng_ ? next_block() : next_classic();
}

std::optional<PcapRecord> PcapRecords::next_classic() {
  if (position_ >= file_->size()) return std::nullopt;
  const auto head = view(position_, kRecordHeader);
  if (!head) return end_damaged("a record is cut off");
  const auto seconds = number_at<std::uint32_t>(*head, 0, is_big_endian_);
  const auto fraction = number_at<std::uint32_t>(*head, 4, is_big_endian_);
  const auto size = number_at<std::uint32_t>(*head, 8, is_big_endian_);
  if (size > kMostRecordBytes) return end_damaged(fmt::format("a record of {} bytes cannot be", size));
  const auto bytes = view(position_ + kRecordHeader, size);
  if (!bytes) return end_damaged("a record is cut off");
  PcapRecord record{.offset = position_, .link_type = link_type_, .bytes = *bytes};
  record.time_ns = seconds * kNsPerSecond + std::int64_t{fraction} * (has_ns_ ? 1 : 1000);
  position_ += kRecordHeader + size;
  return record;
}

std::optional<PcapRecords::Section*> PcapRecords::section_at(std::uint64_t offset, Bytes head) {
  if (little_endian_at<std::uint32_t>(head, 0) == kSectionBlock) {
    if (sections_.empty() || sections_.back().offset < offset) {
      if (sections_.size() >= kMostSections || !is_pcapng(head)) return std::nullopt;
      sections_.push_back({.offset = offset, .is_big_endian = big_endian_at<std::uint32_t>(head, 8) == kByteOrder});
    }
  }
  const auto after = std::upper_bound(sections_.begin(), sections_.end(), offset,
                                      [](std::uint64_t place, const Section& s) { return place < s.offset; });
  if (after == sections_.begin()) return std::nullopt;
  return &*std::prev(after);
}

void PcapRecords::read_interface(Bytes block, std::uint64_t offset, Section& section) const {
  if (offset <= section.interfaces_until || section.interfaces.size() >= kMostInterfaces) return;
  section.interfaces_until = offset;
  const bool big = section.is_big_endian;
  Interface interface { .link_type = number_at<std::uint16_t>(block, 8, big) };
  constexpr std::uint16_t kResolution = 9, kOffset = 14;  // if_tsresol, if_tsoffset
  for (std::size_t at = 16; at + 4 <= block.size();) {
    const auto code = number_at<std::uint16_t>(block, at, big);
    const std::size_t length = number_at<std::uint16_t>(block, at + 2, big);
    if (code == 0 || length > block.size() - at - 4) break;
    if (code == kResolution && length == 1) {
      interface.units_per_s = units_per_s(number_at<std::uint8_t>(block, at + 4, big));
    } else if (code == kOffset && length == 8) {
      interface.offset_s = number_at<std::int64_t>(block, at + 4, big);
    }
    at += 4 + (length + 3) / 4 * 4;
  }
  section.interfaces.push_back(interface);
}

std::optional<PcapRecord> PcapRecords::next_block() {
  constexpr std::uint64_t kHead = 12, kPacketHead = 28, kTail = 4;
  while (position_ < file_->size()) {
    const auto head = view(position_, kHead);
    if (!head) return end_damaged("a block is cut off");
    const auto found = section_at(position_, *head);
    if (!found) return end_damaged("no section of pcapng begins here");
    Section& section = **found;
    const bool big = section.is_big_endian;
    const auto type = number_at<std::uint32_t>(*head, 0, big);
    const std::uint64_t length = number_at<std::uint32_t>(*head, 4, big);
    if (length < kHead || length % 4 != 0) return end_damaged(fmt::format("a block of {} bytes cannot be", length));
    if (length > file_->size() - position_) return end_damaged("a block is cut off");
    const std::uint64_t offset = position_;
    const bool has_packet = (type == kPacketBlock || type == kOldPacketBlock) && length >= kPacketHead + kTail;
    if (!has_packet && type != kInterfaceBlock) {
      position_ += length;
      continue;
    }
    if (length > kMostRecordBytes + kPacketHead + kTail + (64U << 10)) {
      return end_damaged(fmt::format("a block of {} bytes cannot be", length));
    }
    const auto block = view(offset, length);
    if (!block) return end_damaged("a block cannot be read");
    position_ += length;
    if (type == kInterfaceBlock) {
      read_interface(*block, offset, section);
      continue;
    }
    const std::uint32_t index =
        type == kPacketBlock ? number_at<std::uint32_t>(*block, 8, big) : number_at<std::uint16_t>(*block, 8, big);
    const std::uint64_t size = number_at<std::uint32_t>(*block, 20, big);
    if (index >= section.interfaces.size() || size > length - kPacketHead - kTail) continue;
    const Interface& interface = section.interfaces[index];
    const std::uint64_t units =
        (std::uint64_t{number_at<std::uint32_t>(*block, 12, big)} << 32) | number_at<std::uint32_t>(*block, 16, big);
    return PcapRecord{.offset = offset,
                      .time_ns = time_ns_of(units, interface.units_per_s, interface.offset_s),
                      .link_type = interface.link_type,
                      .bytes = block->subspan(kPacketHead, static_cast<std::size_t>(size))};
  }
  return std::nullopt;
}

void UdpDatagrams::seek(std::uint64_t offset) {
  records_.seek(offset);
  pending_.clear();
}

std::optional<UdpDatagram> UdpDatagrams::next() {
  while (const auto record = records_.next()) {
    const Bytes packet = ipv4_of(record->link_type, record->bytes);
    if (auto datagram = from_ip(*record, packet)) return datagram;
  }
  incomplete_ += pending_.size();
  pending_.clear();
  return std::nullopt;
}

/// RFC 791, section 3.1.
std::optional<UdpDatagram> UdpDatagrams::from_ip(const PcapRecord& record, Bytes packet) {
  constexpr std::size_t kLeastHeader = 20;
  constexpr unsigned kUdp = 17, kMoreFragments = 0x2000, kFragmentPlace = 0x1fff;
  if (packet.size() < kLeastHeader) return std::nullopt;
  const unsigned first = big_endian_at<std::uint8_t>(packet, 0);
  const std::size_t header = 4 * std::size_t{first & 0xfU};
  const std::size_t total = big_endian_at<std::uint16_t>(packet, 2);
  const bool is_udp = first >> 4 == 4 && big_endian_at<std::uint8_t>(packet, 9) == kUdp;
  if (!is_udp || header < kLeastHeader || total < header) return std::nullopt;
  if (total > packet.size()) {
    ++cut_short_;
    return std::nullopt;
  }
  Pending origin{.offset = record.offset, .time_ns = record.time_ns};
  origin.source = big_endian_at<std::uint32_t>(packet, 12);
  origin.destination = big_endian_at<std::uint32_t>(packet, 16);
  origin.id = big_endian_at<std::uint16_t>(packet, 4);
  const Bytes content = packet.subspan(header, total - header);
  const unsigned fragment = big_endian_at<std::uint16_t>(packet, 6);
  const std::size_t at = kUnit * (fragment & kFragmentPlace);
  const bool is_last = (fragment & kMoreFragments) == 0;
  if (at == 0 && is_last) return from_udp(origin, content);
  return from_fragment(std::move(origin), at, is_last, content);
}

std::optional<UdpDatagram> UdpDatagrams::from_fragment(Pending fragment, std::size_t at, bool is_last, Bytes bytes) {
  constexpr std::size_t kMostPending = 16;
  constexpr std::int64_t kLongest_ns = kNsPerSecond;  // later fragments of the same number are of another datagram
  const std::size_t end = at + bytes.size();
  if (bytes.empty() || end >= kMostBytes || (!is_last && bytes.size() % kUnit != 0)) return std::nullopt;
  incomplete_ += std::erase_if(pending_, [&](const Pending& old) {
    return fragment.time_ns - old.time_ns > kLongest_ns || old.time_ns - fragment.time_ns > kLongest_ns;
  });
  auto place = std::find_if(pending_.begin(), pending_.end(), [&](const Pending& other) {
    return other.id == fragment.id && other.source == fragment.source && other.destination == fragment.destination;
  });
  if (place == pending_.end()) {
    if (pending_.size() >= kMostPending) {
      pending_.erase(pending_.begin());
      ++incomplete_;
    }
    place = pending_.insert(pending_.end(), std::move(fragment));
  }
  if (place->bytes.size() < end) place->bytes.resize(end);
  std::copy(bytes.begin(), bytes.end(), place->bytes.begin() + static_cast<std::ptrdiff_t>(at));
  for (std::size_t unit = at / kUnit; unit < (end + kUnit - 1) / kUnit; ++unit) place->has_unit.set(unit);
  if (is_last) place->size = end;
  if (place->size == 0) return std::nullopt;
  for (std::size_t unit = 0; unit < (place->size + kUnit - 1) / kUnit; ++unit) {
    if (!place->has_unit.test(unit)) return std::nullopt;
  }
  const Pending complete = std::move(*place);
  pending_.erase(place);
  whole_ = complete.bytes;
  return from_udp(complete, Bytes(whole_).first(complete.size));
}

/// RFC 768.
std::optional<UdpDatagram> UdpDatagrams::from_udp(const Pending& origin, Bytes bytes) {
  constexpr std::size_t kHeader = 8;
  const std::size_t length = big_endian_at<std::uint16_t>(bytes, 4);
  if (bytes.size() < kHeader || length < kHeader || length > bytes.size()) return std::nullopt;
  return UdpDatagram{.offset = origin.offset,
                     .time_ns = origin.time_ns,
                     .source = origin.source,
                     .port = big_endian_at<std::uint16_t>(bytes, 2),
                     .payload = bytes.subspan(kHeader, length - kHeader)};
}

}  // namespace scanknit
