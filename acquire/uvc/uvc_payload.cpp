#include "acquire/uvc/uvc_payload.h"

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

// bmHeaderInfo.
constexpr int kFrameIdBit = 0x01;
constexpr int kEndBit = 0x02;
constexpr int kTicksBit = 0x04;
constexpr int kSourceClockBit = 0x08;
constexpr int kErrorBit = 0x40;

/// librealsense, src/metadata.h: md_capture_timing; u32 type and u32 size, then version, flags, frame counter ...
constexpr std::uint32_t kCaptureTiming = 0x80000001;

std::optional<std::uint32_t> frame_counter_of(ByteReader metadata) {
  const auto type = metadata.little_endian<std::uint32_t>();
  if (type != kCaptureTiming || !metadata.take(12)) return std::nullopt;  // size, version, flags
  return metadata.little_endian<std::uint32_t>();
}

}  // namespace

std::optional<UvcPayloadHeader> parse_payload_header(std::span<const std::byte> payload) {
  ByteReader reader(payload);
  const auto length = reader.little_endian<std::uint8_t>();
  if (!length || *length < 2 || *length > payload.size()) return std::nullopt;
  ByteReader rest(*reader.take(*length - 1u));
  const int info = *rest.little_endian<std::uint8_t>();
  UvcPayloadHeader header;
  header.bytes = *length;
  header.frame_id = (info & kFrameIdBit) != 0;
  header.is_end = (info & kEndBit) != 0;
  header.has_error = (info & kErrorBit) != 0;
  if ((info & kTicksBit) != 0) {
    header.presentation_ticks = rest.little_endian<std::uint32_t>();
    if (!header.presentation_ticks) return std::nullopt;
  }
  if ((info & kSourceClockBit) != 0 && !rest.take(6)) return std::nullopt;
  header.frame_counter = frame_counter_of(rest);
  return header;
}

}  // namespace scanknit
