#include "tests/usb/vcam/vkinect.h"

#include <algorithm>
#include <cstring>

#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

constexpr std::size_t kPixels = 640 * 480;
constexpr std::int64_t kIntervalNs = 33'333'333;
constexpr std::size_t kHeaderBytes = 12;

/// Eleven bits a pixel, the first pixel in the highest bits.
std::vector<std::byte> packed_depth(int value) {
  std::vector<std::byte> bytes(kPixels * 11 / 8);
  std::uint32_t bits = 0;
  int count = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < kPixels; ++i) {
    bits = bits << 11 | static_cast<std::uint32_t>(value);
    count += 11;
    for (; count >= 8; count -= 8) bytes[at++] = static_cast<std::byte>((bits >> (count - 8)) & 0xFF);
  }
  return bytes;
}

int u16_at(std::span<const std::byte> bytes, std::size_t at) {
  return std::to_integer<int>(bytes[at]) | std::to_integer<int>(bytes[at + 1]) << 8;
}

}  // namespace

std::vector<std::byte> VKinect::descriptors() const {
  Bytes bytes{18, 1, 0, 2, 0, 0, 0, 64};
  bytes.u16(0x045e).u16(options_.product).u16(0x010b).add({2, 1, 3, 1});
  Bytes parts = descriptor({4, 0, 0, 2, 0xFF, 0xFF, 0xFF, 0});
  for (const int endpoint : {kColourEndpoint, kDepthEndpoint}) {
    parts.add(descriptor(Bytes{5, endpoint, 1}.u16(0x0BC0).u8(1)));  // 2 x 960
  }
  bytes.add({9, 2}).u16(static_cast<std::uint32_t>(parts.size() + 9)).add({1, 1, 0, 0xC0, 8});
  return bytes.add(parts).vector();
}

/// A command is {'G' 'M', words, opcode, tag}, its answer {'R' 'B', words, opcode, tag} and what follows.
std::optional<std::vector<std::byte>> VKinect::control(std::uint8_t type, std::uint8_t, std::uint16_t, std::uint16_t,
                                                       std::uint16_t length, std::span<const std::byte> data,
                                                       std::int64_t now_ns) {
  if (type == 0xC0) {
    auto answer = reply_;
    answer.resize(std::min<std::size_t>(answer.size(), length));
    return answer;
  }
  if (type == 0x80) return Bytes{4, 3, 0x09, 0x04}.vector();  // string descriptors: there are none
  if (type != 0x40 || data.size() < 8) return std::nullopt;
  const int opcode = u16_at(data, 4);
  Bytes body;
  if (opcode == 0x03) {  // write a register
    set_register(u16_at(data, 8), u16_at(data, 10), now_ns);
    body.u16(0);
  } else if (opcode == 0x04) {  // fixed parameters: emitter, colour camera, reference plane and its pixel, in cm
    body.fill(94).f32(7.5F).f32(2.3F).f32(120.0F).f32(0.1042F).fill(322 - 94 - 16);
  } else if (opcode == 0x16 && u16_at(data, 8) == 0x40) {  // registration: none
    body.fill(118);
  } else if (opcode == 0x16 && u16_at(data, 8) == 0x41) {  // padding of the picture
    body.fill(8);
  } else {  // constant shift
    body.u16(0).u16(200);
  }
  Bytes reply{0x52, 0x42};
  reply.u16(static_cast<std::uint32_t>(body.size() / 2)).u16(static_cast<std::uint32_t>(opcode));
  reply_ = reply.u16(static_cast<std::uint32_t>(u16_at(data, 6))).add(body).vector();
  return std::vector<std::byte>{};
}

void VKinect::set_register(int address, int value, std::int64_t now_ns) {
  constexpr int kColourStream = 0x05, kDepthStream = 0x06;
  if (address != kColourStream && address != kDepthStream) return;
  Stream& stream = streams_[address == kDepthStream ? 0 : 1];
  stream.is_active = value != 0;
  if (address == kDepthStream && value != 0) ++starts;
  stream.due_ns = now_ns;
  stream.sent = 0;
  stream.flag = address == kDepthStream ? 0x70 : 0x80;
  stream.packet_bytes = address == kDepthStream ? 1748 : 1908;
  if (stream.picture.empty()) {
    stream.picture =
        address == kDepthStream ? packed_depth(options_.raw_depth) : std::vector<std::byte>(kPixels, std::byte{128});
  }
}

Delivery VKinect::fill_packet(std::uint8_t endpoint, std::span<std::byte> packet, std::int64_t now_ns) {
  Stream& stream = stream_of(endpoint);
  const bool is_all_silent = depth_pictures >= silent_from && starts < silent_until_starts;
  const bool is_silent = is_all_silent || (endpoint == kColourEndpoint && stream.number >= colour_silent_from);
  if (!stream.is_active || is_silent || now_ns < stream.due_ns) return {};
  const std::size_t size = std::min(stream.packet_bytes, stream.picture.size() - stream.sent);
  const bool is_first = stream.sent == 0, is_last = stream.sent + size == stream.picture.size();
  const bool is_damaged = loses_packet.count(stream.number) > 0 || stream.number >= loses_packets_from;
  const bool is_lost =
      endpoint == kDepthEndpoint && is_damaged && !is_first && stream.sent / stream.packet_bytes == 100;
  Bytes bytes{'R', 'B', 0, stream.flag | (is_first ? 1 : is_last ? 5 : 2), 0, stream.sequence++, 0, 0};
  bytes.u32(static_cast<std::uint32_t>(now_ns / 1000 * 60));
  std::memcpy(packet.data(), bytes.span().data(), kHeaderBytes);
  std::memcpy(packet.data() + kHeaderBytes, stream.picture.data() + stream.sent, size);
  stream.sent += size;
  if (is_last) {
    stream.sent = 0;
    stream.due_ns += kIntervalNs;
    ++stream.number;
    if (endpoint == kDepthEndpoint) ++depth_pictures;
  }
  return is_lost ? Delivery{} : Delivery{0, kHeaderBytes + size};
}

}  // namespace scanknit::test
