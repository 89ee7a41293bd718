#include "acquire/record/picture_message.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "acquire/mcap/byte_appender.h"
#include "acquire/mcap/zstd_bytes.h"
#include "acquire/record/depth_codec.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint8_t kVersion1 = 1;
constexpr std::size_t kHeaderBytes = 32;

/// The values are written into recordings.
enum class Packing : std::uint8_t { kNone = 0, kZstd = 1, kDz1 = 2 };

std::size_t pixels_of(const StreamProfile& profile) {
  return static_cast<std::size_t>(profile.width) * static_cast<std::size_t>(profile.height);
}

Packing packing_for(const RawFrame& frame) {
  if (frame.profile.format == PixelFormat::kMjpeg) return Packing::kNone;
  const bool is_whole_depth =
      frame.profile.format == PixelFormat::kZ16 && frame.bytes->size() == 2 * pixels_of(frame.profile);
  return is_whole_depth ? Packing::kDz1 : Packing::kZstd;
}

Error malformed(const std::string& what) {
  return {ErrorCode::kInput, "the picture's message " + what};
}

struct Header {
  StreamProfile profile;
  Packing packing = Packing::kNone;
  std::size_t bytes = 0;  // of the picture when unpacked
  std::uint64_t sequence = 0;
};

Result<Header> parse_header(ByteReader& reader, const Limits& limits) {
  if (reader.remaining() < kHeaderBytes) return malformed("is truncated");
  const auto version = reader.little_endian<std::uint8_t>().value_or(0);
  const auto kind = reader.little_endian<std::uint8_t>().value_or(0);
  const auto format = reader.little_endian<std::uint8_t>().value_or(0);
  const auto packing = reader.little_endian<std::uint8_t>().value_or(0);
  const auto width = reader.little_endian<std::uint32_t>().value_or(0);
  const auto height = reader.little_endian<std::uint32_t>().value_or(0);
  const auto bytes = reader.little_endian<std::uint32_t>().value_or(0);
  Header header;
  header.sequence = reader.little_endian<std::uint64_t>().value_or(0);
  header.profile.frames_per_second = reader.little_endian<double>().value_or(0);
  if (version != kVersion1) return malformed("has version " + std::to_string(version) + ", expected 1");
  if (kind > static_cast<std::uint8_t>(StreamKind::kColour) || format > static_cast<std::uint8_t>(PixelFormat::kY8i) ||
      packing > static_cast<std::uint8_t>(Packing::kDz1) || !std::isfinite(header.profile.frames_per_second)) {
    return malformed("has an unknown format");
  }
  const auto pixels = checked_mul<std::uint64_t>(width, height);
  if (!pixels || *pixels == 0 || *pixels > static_cast<std::uint64_t>(limits.max_image_pixels)) {
    return malformed("has " + std::to_string(width) + " x " + std::to_string(height) + " pixels, which is not read");
  }
  if (bytes > limits.max_image_bytes) return malformed("has more bytes than " + std::to_string(limits.max_image_bytes));
  header.packing = static_cast<Packing>(packing);
  if (header.packing == Packing::kDz1 && bytes != 2 * *pixels) return malformed("contradicts itself about its size");
  header.profile.kind = static_cast<StreamKind>(kind);
  header.profile.format = static_cast<PixelFormat>(format);
  header.profile.width = static_cast<int>(width);
  header.profile.height = static_cast<int>(height);
  header.bytes = bytes;
  return header;
}

Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed, const Header& header) {
  switch (header.packing) {
    case Packing::kDz1: return decode_depth(packed, pixels_of(header.profile));
    case Packing::kZstd: return zstd_unpack(packed, header.bytes);
    case Packing::kNone: break;
  }
  if (packed.size() != header.bytes) return malformed("contradicts itself about its size");
  return std::vector<std::byte>(packed.begin(), packed.end());
}

}  // namespace

std::vector<std::byte> pack_picture(const RawFrame& frame) {
  SCANKNIT_CHECK(frame.bytes && frame.profile.width > 0 && frame.profile.height > 0);
  const Packing packing = packing_for(frame);
  std::vector<std::byte> message;
  ByteAppender writer(message);
  writer.little_endian(kVersion1);
  writer.little_endian(static_cast<std::uint8_t>(frame.profile.kind));
  writer.little_endian(static_cast<std::uint8_t>(frame.profile.format));
  writer.little_endian(static_cast<std::uint8_t>(packing));
  writer.little_endian(static_cast<std::uint32_t>(frame.profile.width));
  writer.little_endian(static_cast<std::uint32_t>(frame.profile.height));
  writer.little_endian(static_cast<std::uint32_t>(frame.bytes->size()));
  writer.little_endian(frame.sequence);
  writer.little_endian(frame.profile.frames_per_second);
  SCANKNIT_CHECK(message.size() == kHeaderBytes);
  switch (packing) {
    case Packing::kNone: writer.append(*frame.bytes); break;
    case Packing::kZstd: writer.append(zstd_pack(*frame.bytes)); break;
    case Packing::kDz1: writer.append(encode_depth(*frame.bytes)); break;
  }
  return message;
}

Result<RawFrame> unpack_picture(std::span<const std::byte> message, const Limits& limits) {
  ByteReader reader(message);
  const auto header = parse_header(reader, limits);
  if (!header) return header.error();
  auto bytes = unpack(*reader.take(reader.remaining()), *header);
  if (!bytes) return bytes.error();
  RawFrame frame;
  frame.profile = header->profile;
  frame.sequence = header->sequence;
  frame.bytes = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
  return frame;
}

}  // namespace scanknit
