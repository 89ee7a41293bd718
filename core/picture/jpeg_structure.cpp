#include "core/picture/jpeg_structure.h"

#include <cstdint>
#include <optional>
#include <string>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

// Marker codes of ITU-T T.81, table B.1.
constexpr std::uint8_t kMarker = 0xFF, kSoi = 0xD8, kEoi = 0xD9, kSos = 0xDA, kRst0 = 0xD0, kRst7 = 0xD7, kTem = 0x01;
constexpr std::uint8_t kSof0 = 0xC0, kSof15 = 0xCF, kDht = 0xC4, kJpg = 0xC8, kDac = 0xCC;

bool is_frame_header(std::uint8_t code) {
  return code >= kSof0 && code <= kSof15 && code != kDht && code != kJpg && code != kDac;
}

bool stands_alone(std::uint8_t code) {
  return (code >= kRst0 && code <= kRst7) || code == kTem;
}

// The next marker code; entropy-coded bytes, stuffed zeros and fill bytes before it are passed over.
std::optional<std::uint8_t> next_marker(ByteReader& reader) {
  for (bool after_ff = false;;) {
    const auto byte = reader.big_endian<std::uint8_t>();
    if (!byte) return std::nullopt;
    if (after_ff && *byte != 0 && *byte != kMarker) return byte;
    after_ff = *byte == kMarker;
  }
}

Result<JpegHeader> parse_frame_header(std::span<const std::byte> segment, const Limits& limits) {
  ByteReader reader(segment);
  const auto precision = reader.big_endian<std::uint8_t>();
  const auto height = reader.big_endian<std::uint16_t>();
  const auto width = reader.big_endian<std::uint16_t>();
  if (!precision || !height || !width) return Error{ErrorCode::kInput, "truncated JPEG"};
  if (*width == 0 || *height == 0 || std::int64_t{*width} * *height > limits.max_image_pixels) {
    return Error{ErrorCode::kInput,
                 "JPEG of " + std::to_string(*width) + " x " + std::to_string(*height) + " pixels is not read"};
  }
  return JpegHeader{*width, *height};
}

}  // namespace

bool looks_like_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{kMarker} && bytes[1] == std::byte{kSoi} &&
         bytes[2] == std::byte{kMarker};
}

Result<JpegHeader> check_jpeg(std::span<const std::byte> bytes, const Limits& limits) {
  if (!looks_like_jpeg(bytes)) return Error{ErrorCode::kInput, "not a JPEG file"};
  const Error truncated{ErrorCode::kInput, "truncated JPEG"};
  ByteReader reader(bytes.subspan(2));
  std::optional<JpegHeader> header;
  bool has_scan = false;
  for (;;) {
    const auto code = next_marker(reader);
    if (!code) return truncated;
    if (*code == kEoi) break;
    if (stands_alone(*code)) continue;
    const auto length = reader.big_endian<std::uint16_t>();  // counts its own two bytes
    if (!length || *length < 2) return truncated;
    const auto segment = reader.take(*length - std::size_t{2});
    if (!segment) return truncated;
    has_scan |= *code == kSos;
    if (is_frame_header(*code)) {
      // A second frame header could name another size than the one that was checked.
      if (header) return Error{ErrorCode::kInput, "corrupt JPEG: two frame headers"};
      const auto parsed = parse_frame_header(*segment, limits);
      if (!parsed) return parsed.error();
      header = *parsed;
    }
  }
  if (!header || !has_scan) return Error{ErrorCode::kInput, "corrupt JPEG: no picture data"};
  return *header;
}

}  // namespace scanknit
