#include "acquire/uvc/uvc_probe.h"

#include <string>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::size_t kShortest = 26;

void put_u32(std::vector<std::byte>& bytes, std::size_t offset, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[offset + i] = static_cast<std::byte>((value >> (8 * i)) & 0xFF);
}

}  // namespace

std::size_t probe_bytes(std::uint16_t uvc_version) {
  if (uvc_version >= 0x0150) return 48;
  return uvc_version >= 0x0110 ? 34 : kShortest;
}

std::vector<std::byte> encode_probe(const UvcStreamControl& control, std::size_t bytes) {
  std::vector<std::byte> out(bytes);
  out[0] = std::byte{1};  // bmHint: keep dwFrameInterval
  out[2] = std::byte{control.format_index};
  out[3] = std::byte{control.frame_index};
  put_u32(out, 4, control.interval_100ns);
  put_u32(out, 18, control.max_frame_bytes);
  put_u32(out, 22, control.max_payload_bytes);
  return out;
}

Result<UvcStreamControl> decode_probe(std::span<const std::byte> bytes) {
  if (bytes.size() < kShortest) {
    return Error{ErrorCode::kDevice, "the camera answered the stream negotiation with " + std::to_string(bytes.size()) +
                                         " bytes, expected 26, 34 or 48"};
  }
  ByteReader reader(bytes);
  (void)reader.take(2);  // bmHint
  UvcStreamControl control;
  control.format_index = *reader.little_endian<std::uint8_t>();
  control.frame_index = *reader.little_endian<std::uint8_t>();
  control.interval_100ns = *reader.little_endian<std::uint32_t>();
  (void)reader.take(10);  // wKeyFrameRate to wDelay
  control.max_frame_bytes = *reader.little_endian<std::uint32_t>();
  control.max_payload_bytes = *reader.little_endian<std::uint32_t>();
  return control;
}

}  // namespace scanknit
