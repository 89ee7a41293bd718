// LZFSE's own blocks: literals, and triplets (literals to copy, length of a match, its distance), each coded by finite
// state entropy.
#include <array>
#include <cstdint>
#include <optional>

#include "acquire/phones/lzfse_blocks.h"
#include "acquire/phones/lzfse_entropy.h"

namespace scanknit {
namespace {

constexpr std::size_t kLengthSymbols = 20, kDistanceSymbols = 64, kLiteralSymbols = 256;
constexpr std::size_t kLengthStates = 64, kDistanceStates = 256, kLiteralStates = 1024;
constexpr std::size_t kAllSymbols = 2 * kLengthSymbols + kDistanceSymbols + kLiteralSymbols;
constexpr std::uint32_t kMostMatches = 10'000;
constexpr std::uint32_t kMostLiterals = 4 * kMostMatches;

/// A value is a symbol's least value, and so many bits that are added to it.
struct ValueRange {
  std::uint32_t least = 0;
  unsigned bits = 0;
};

constexpr std::array<unsigned, 4> kLongLiteralBits = {2, 3, 5, 8};  // of the last four symbols; the others have none
constexpr std::array<unsigned, 4> kLongMatchBits = {3, 5, 8, 11};

constexpr std::array<ValueRange, kLengthSymbols> length_ranges(const std::array<unsigned, 4>& long_bits) {
  std::array<ValueRange, kLengthSymbols> ranges{};
  std::uint32_t least = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const std::size_t plain = ranges.size() - long_bits.size();
    ranges[i] = {least, i < plain ? 0 : long_bits[i - plain]};
    least += 1u << ranges[i].bits;
  }
  return ranges;
}

constexpr std::array<ValueRange, kDistanceSymbols> distance_ranges() {
  std::array<ValueRange, kDistanceSymbols> ranges{};
  std::uint32_t least = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ranges[i] = {least, static_cast<unsigned>(i / 4)};  // four symbols of each number of bits
    least += 1u << ranges[i].bits;
  }
  return ranges;
}

constexpr auto kLiteralLengths = length_ranges(kLongLiteralBits);
constexpr auto kMatchLengths = length_ranges(kLongMatchBits);
constexpr auto kDistances = distance_ranges();

struct FseHeader {
  std::uint32_t unpacked_bytes = 0, literals = 0, matches = 0, literal_bytes = 0, triplet_bytes = 0;
  unsigned literal_unused = 0, triplet_unused = 0;  ///< bits at the end of these payloads
  std::array<std::uint32_t, 4> literal_states{};
  std::uint32_t length_state = 0, match_state = 0, distance_state = 0;
  std::array<std::uint16_t, kAllSymbols> frequencies{};
};

/// Frequencies as prefix codes of 2 to 14 bits, the lowest bit first.
bool take_packed_frequencies(std::span<const std::byte> packed, std::span<std::uint16_t> frequencies) {
  std::uint32_t bits = 0;
  unsigned count = 0;
  std::size_t next = 0;
  for (std::uint16_t& frequency : frequencies) {
    for (; count <= 24 && next < packed.size(); count += 8)
      bits |= std::to_integer<std::uint32_t>(packed[next++]) << count;
    unsigned used = 14;
    std::uint32_t value = 24 + (bits >> 4 & 0x3FF);  // 1111
    if ((bits & 1) == 0) {
      used = 2;
      value = bits >> 1 & 1;
    } else if ((bits & 3) == 1) {
      used = 3;
      value = 2 + (bits >> 2 & 1);
    } else if ((bits & 7) == 3) {
      used = 5;
      value = 4 + (bits >> 3 & 3);
    } else if ((bits & 15) == 7) {
      used = 8;
      value = 8 + (bits >> 4 & 15);
    }
    if (used > count) return false;
    frequency = static_cast<std::uint16_t>(value);
    bits >>= used;
    count -= used;
  }
  return next == packed.size() && count < 8;
}

/// 0 to 7 of -7 to 0.
std::optional<unsigned> unused_bits(std::int32_t stated) {
  return stated >= -7 && stated <= 0 ? std::optional(static_cast<unsigned>(-stated)) : std::nullopt;
}

std::optional<FseHeader> take_plain_header(ByteReader& reader) {
  constexpr std::size_t kBytes = 6 * 4 + 4 + 4 * 2 + 4 + 3 * 2 + 2 * kAllSymbols + 2;  // without its four letters
  const auto bytes = reader.take(kBytes);
  if (!bytes) return std::nullopt;
  ByteReader from(*bytes);
  FseHeader header;
  header.unpacked_bytes = *from.little_endian<std::uint32_t>();
  (void)from.little_endian<std::uint32_t>();  // the sum of both payloads
  for (std::uint32_t* value : {&header.literals, &header.matches, &header.literal_bytes, &header.triplet_bytes}) {
    *value = *from.little_endian<std::uint32_t>();
  }
  const auto literal_unused = unused_bits(*from.little_endian<std::int32_t>());
  for (std::uint32_t& state : header.literal_states) state = *from.little_endian<std::uint16_t>();
  const auto triplet_unused = unused_bits(*from.little_endian<std::int32_t>());
  for (std::uint32_t* state : {&header.length_state, &header.match_state, &header.distance_state}) {
    *state = *from.little_endian<std::uint16_t>();
  }
  for (std::uint16_t& frequency : header.frequencies) frequency = *from.little_endian<std::uint16_t>();
  if (!literal_unused || !triplet_unused) return std::nullopt;
  header.literal_unused = *literal_unused;
  header.triplet_unused = *triplet_unused;
  return header;
}

/// The same in three numbers of 64 bits, and the frequencies packed.
std::optional<FseHeader> take_packed_header(ByteReader& reader) {
  constexpr std::size_t kFixedBytes = 4 + 3 * 8;  // without its four letters
  const auto fixed = reader.take(kFixedBytes);
  if (!fixed) return std::nullopt;
  ByteReader from(*fixed);
  FseHeader header;
  header.unpacked_bytes = *from.little_endian<std::uint32_t>();
  std::array<std::uint64_t, 3> numbers{};
  for (std::uint64_t& number : numbers) number = *from.little_endian<std::uint64_t>();
  const auto field = [&](std::size_t number, unsigned first, unsigned count) {
    return static_cast<std::uint32_t>(numbers[number] >> first & ((std::uint64_t{1} << count) - 1));
  };
  header.literals = field(0, 0, 20);
  header.literal_bytes = field(0, 20, 20);
  header.matches = field(0, 40, 20);
  header.literal_unused = 7 - field(0, 60, 3);
  for (unsigned i = 0; i < header.literal_states.size(); ++i) header.literal_states[i] = field(1, 10 * i, 10);
  header.triplet_bytes = field(1, 40, 20);
  header.triplet_unused = 7 - field(1, 60, 3);
  const std::size_t header_bytes = field(2, 0, 32);
  header.length_state = field(2, 32, 10);
  header.match_state = field(2, 42, 10);
  header.distance_state = field(2, 52, 10);
  constexpr std::size_t kBefore = 4 + kFixedBytes;
  if (header_bytes < kBefore) return std::nullopt;
  const auto packed = reader.take(header_bytes - kBefore);
  if (!packed) return std::nullopt;
  const bool is_whole = packed->empty() || take_packed_frequencies(*packed, header.frequencies);
  return is_whole ? std::optional(header) : std::nullopt;
}

struct FseDecoders {
  FseDecoder<kLengthStates> lengths, matches;
  FseDecoder<kDistanceStates> distances;
  FseDecoder<kLiteralStates> literals;

  [[nodiscard]] bool build(const FseHeader& header) {
    const std::span<const std::uint16_t> all(header.frequencies);
    return lengths.build(all.first(kLengthSymbols)) && matches.build(all.subspan(kLengthSymbols, kLengthSymbols)) &&
           distances.build(all.subspan(2 * kLengthSymbols, kDistanceSymbols)) &&
           literals.build(all.last(kLiteralSymbols));
  }
};

/// Four states take turns.
bool take_literals(FseHeader header, std::span<const std::byte> payload, const FseDecoders& decoders,
                   std::vector<std::byte>& literals) {
  auto bits = BackwardBits::of(payload, header.literal_unused);
  if (!bits) return false;
  for (std::uint32_t i = 0; i < header.literals; ++i) {
    const auto symbol = decoders.literals.take(header.literal_states[i % 4], *bits);
    if (!symbol) return false;
    literals.push_back(static_cast<std::byte>(*symbol));
  }
  return true;
}

template <typename Decoder, std::size_t Symbols>
std::optional<std::uint32_t> take_value(const Decoder& decoder, const std::array<ValueRange, Symbols>& ranges,
                                        std::uint32_t& state, BackwardBits& bits) {
  const auto symbol = decoder.take(state, bits);
  if (!symbol) return std::nullopt;
  const ValueRange& range = ranges[*symbol];
  const auto more = bits.take(range.bits);
  return more ? std::optional(range.least + *more) : std::nullopt;
}

bool run_triplets(FseHeader header, std::span<const std::byte> payload, const FseDecoders& decoders,
                  std::span<const std::byte> literals, LzOutput& output) {
  auto bits = BackwardBits::of(payload, header.triplet_unused);
  if (!bits) return false;
  std::size_t distance = 0;
  for (std::uint32_t i = 0; i < header.matches; ++i) {
    const auto length = take_value(decoders.lengths, kLiteralLengths, header.length_state, *bits);
    const auto match = length ? take_value(decoders.matches, kMatchLengths, header.match_state, *bits) : std::nullopt;
    const auto back = match ? take_value(decoders.distances, kDistances, header.distance_state, *bits) : std::nullopt;
    if (!back || *length > literals.size() || !output.append(literals.first(*length))) return false;
    literals = literals.subspan(*length);
    if (*back != 0) distance = *back;  // 0: that of the match before
    if (!output.append_match(distance, *match)) return false;
  }
  return true;
}

}  // namespace

bool unpack_fse_block(ByteReader& reader, bool has_packed_tables, LzOutput& output) {
  const auto header = has_packed_tables ? take_packed_header(reader) : take_plain_header(reader);
  if (!header || header->literals > kMostLiterals || header->matches > kMostMatches) return false;
  const auto literal_payload = reader.take(header->literal_bytes);
  const auto triplet_payload = literal_payload ? reader.take(header->triplet_bytes) : std::nullopt;
  FseDecoders decoders;
  std::vector<std::byte> literals;
  return triplet_payload && decoders.build(*header) && output.begin_block(header->unpacked_bytes) &&
         take_literals(*header, *literal_payload, decoders, literals) &&
         run_triplets(*header, *triplet_payload, decoders, literals, output) && output.is_block_full();
}

}  // namespace scanknit
