// LZVN: instructions of one to three bytes, each with literals, a match, or both.
#include <cstdint>

#include "acquire/phones/lzfse_blocks.h"

namespace scanknit {
namespace {

enum class LzvnKind { kNothing, kEnd, kInvalid, kInstruction };

struct LzvnInstruction {
  LzvnKind kind = LzvnKind::kInstruction;
  std::size_t literals = 0, match = 0;
};

constexpr std::size_t kEndBytes = 8;  // 06, and seven of no meaning

/// LLMMMDDD DDDDDDDD, LLMMM111 and two bytes of distance, LLMMM110 with the distance of the match before.
LzvnInstruction take_near_match(std::uint8_t code, ByteReader& reader, std::size_t& distance) {
  constexpr unsigned kFarther = 7, kSame = 6;
  const LzvnInstruction instruction{.literals = std::size_t{code} >> 6, .match = ((std::size_t{code} >> 3) & 7) + 3};
  const unsigned low = code & 7u;
  if (low == kSame) return instruction;
  if (low == kFarther) {
    const auto bytes = reader.little_endian<std::uint16_t>();
    if (!bytes) return {LzvnKind::kInvalid};
    distance = *bytes;
    return instruction;
  }
  const auto byte = reader.little_endian<std::uint8_t>();
  if (!byte) return {LzvnKind::kInvalid};
  distance = std::size_t{low} << 8 | *byte;
  return instruction;
}

/// 101LLMMM DDDDDDMM DDDDDDDD
LzvnInstruction take_middle_match(std::uint8_t code, ByteReader& reader, std::size_t& distance) {
  const auto rest = reader.little_endian<std::uint16_t>();
  if (!rest) return {LzvnKind::kInvalid};
  distance = *rest >> 2;
  return {.literals = (std::size_t{code} >> 3) & 3, .match = (std::size_t{code & 7u} << 2 | (*rest & 3u)) + 3};
}

/// 1110LLLL, 1111MMMM; where these four bits are 0, a byte more of the number less 16.
LzvnInstruction take_one_kind(std::uint8_t code, ByteReader& reader) {
  std::size_t count = code & 15u;
  if (count == 0) {
    const auto more = reader.little_endian<std::uint8_t>();
    if (!more) return {LzvnKind::kInvalid};
    count = std::size_t{*more} + 16;
  }
  return code < 0xF0 ? LzvnInstruction{.literals = count} : LzvnInstruction{.match = count};
}

/// Changes `distance` where the instruction states one.
LzvnInstruction take_instruction(ByteReader& reader, std::size_t& distance) {
  const auto code = reader.little_endian<std::uint8_t>();
  if (!code) return {LzvnKind::kInvalid};
  if (*code >= 0xE0) return take_one_kind(*code, reader);
  if (*code >= 0xD0 || (*code >= 0x70 && *code < 0x80)) return {LzvnKind::kInvalid};
  if (*code >= 0xA0 && *code < 0xC0) return take_middle_match(*code, reader, distance);
  if (*code < 0x40 && (*code & 7u) == 6) {  // no literals, and the distance before: other meanings
    if (*code == 0x06) return {reader.take(kEndBytes - 1) ? LzvnKind::kEnd : LzvnKind::kInvalid};
    return {*code == 0x0E || *code == 0x16 ? LzvnKind::kNothing : LzvnKind::kInvalid};
  }
  return take_near_match(*code, reader, distance);
}

}  // namespace

bool unpack_lzvn_block(ByteReader& reader, LzOutput& output) {
  const auto unpacked_bytes = reader.little_endian<std::uint32_t>();
  const auto packed_bytes = reader.little_endian<std::uint32_t>();
  const auto packed = packed_bytes ? reader.take(*packed_bytes) : std::nullopt;
  if (!packed || !output.begin_block(*unpacked_bytes)) return false;
  ByteReader instructions(*packed);
  std::size_t distance = 0;
  for (;;) {
    const LzvnInstruction next = take_instruction(instructions, distance);
    if (next.kind == LzvnKind::kInvalid) return false;
    if (next.kind == LzvnKind::kEnd) return output.is_block_full() && instructions.remaining() == 0;
    const auto literals = instructions.take(next.literals);
    if (!literals || !output.append(*literals) || !output.append_match(distance, next.match)) return false;
  }
}

}  // namespace scanknit
