#include "core/picture/png_structure.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/files/byte_reader.h"
#include "core/files/crc32.h"

namespace scanknit {
namespace {

constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

constexpr std::uint32_t chunk_type(char a, char b, char c, char d) {
  return static_cast<std::uint32_t>(static_cast<unsigned char>(a)) << 24 |
         static_cast<std::uint32_t>(static_cast<unsigned char>(b)) << 16 |
         static_cast<std::uint32_t>(static_cast<unsigned char>(c)) << 8 | static_cast<unsigned char>(d);
}
constexpr std::uint32_t kIhdr = chunk_type('I', 'H', 'D', 'R');
constexpr std::uint32_t kIdat = chunk_type('I', 'D', 'A', 'T');
constexpr std::uint32_t kIend = chunk_type('I', 'E', 'N', 'D');
constexpr std::uint32_t kIhdrLength = 13;
constexpr std::uint32_t kAncillaryBit = 0x20000000;  // lower-case first letter

Error broken(const char* what) {
  return Error{ErrorCode::kInput, what};
}

struct Chunk {
  std::uint32_t type = 0;
  std::span<const std::byte> data;
  std::span<const std::byte> whole;  // length, type, data, CRC
};

Result<Chunk> read_chunk(std::span<const std::byte> bytes, ByteReader& reader) {
  const std::size_t begin = reader.offset();
  const auto length = reader.big_endian<std::uint32_t>();
  const auto type = reader.big_endian<std::uint32_t>();
  if (!length || !type) return broken("truncated PNG");
  const auto data = reader.take(*length);
  const auto crc = reader.big_endian<std::uint32_t>();
  if (!data || !crc) return broken("truncated PNG");
  if (*crc != crc32(bytes.subspan(begin + 4, std::size_t{*length} + 4))) return broken("corrupt PNG: a CRC is wrong");
  return Chunk{*type, *data, bytes.subspan(begin, reader.offset() - begin)};
}

bool take_signature(ByteReader& reader) {
  const auto signature = reader.take(kSignature.size());
  return signature && std::equal(kSignature.begin(), kSignature.end(), signature->begin(),
                                 [](std::uint8_t a, std::byte b) { return std::byte{a} == b; });
}

Result<PngHeader> parse_ihdr(std::span<const std::byte> data, const Limits& limits) {
  ByteReader reader(data);
  const auto width = reader.big_endian<std::uint32_t>();
  const auto height = reader.big_endian<std::uint32_t>();
  const auto bit_depth = reader.big_endian<std::uint8_t>();
  const auto colour_type = reader.big_endian<std::uint8_t>();
  if (!width || !height || !bit_depth || !colour_type) return broken("truncated PNG");
  constexpr std::uint32_t kMaxSide = 0x7FFFFFFF;  // the specification's own; the product then fits 64 bits
  if (*width == 0 || *height == 0 || *width > kMaxSide || *height > kMaxSide ||
      std::int64_t{*width} * *height > limits.max_image_pixels) {
    return Error{ErrorCode::kInput, "PNG of " + std::to_string(*width) + " x " + std::to_string(*height) +
                                        " pixels; pictures of 1 to " + std::to_string(limits.max_image_pixels) +
                                        " pixels are read"};
  }
  return PngHeader{static_cast<int>(*width), static_cast<int>(*height), *bit_depth, *colour_type == 0,
                   (*colour_type & 4) != 0};
}

}  // namespace

Result<PngHeader> read_png_header(std::span<const std::byte> bytes, const Limits& limits) {
  ByteReader reader(bytes);
  if (bytes.empty()) return broken("the file is empty");
  if (!take_signature(reader)) return broken("not a PNG file");
  const auto ihdr = read_chunk(bytes, reader);
  if (!ihdr) return ihdr.error();
  if (ihdr->type != kIhdr || ihdr->data.size() != kIhdrLength) return broken("corrupt PNG: no IHDR chunk");
  return parse_ihdr(ihdr->data, limits);
}

Result<PngFile> check_png(std::span<const std::byte> bytes, const Limits& limits) {
  const auto header = read_png_header(bytes, limits);
  if (!header) return header.error();
  PngFile file{*header, {}};
  file.critical.reserve(bytes.size());
  ByteReader reader(bytes);
  const auto signature = reader.take(kSignature.size());
  file.critical.assign(signature->begin(), signature->end());
  bool has_data = false;
  for (;;) {
    const auto chunk = read_chunk(bytes, reader);
    if (!chunk) return chunk.error();
    if ((chunk->type & kAncillaryBit) == 0) {
      file.critical.insert(file.critical.end(), chunk->whole.begin(), chunk->whole.end());
    }
    has_data |= chunk->type == kIdat && !chunk->data.empty();
    if (chunk->type == kIend) break;
  }
  if (!has_data) return broken("corrupt PNG: no picture data");
  return file;
}

}  // namespace scanknit
