#include "acquire/mcap/mcap_summary.h"

#include <algorithm>
#include <array>

#include "core/files/byte_reader.h"
#include "core/files/crc32.h"

namespace scanknit {
namespace {

constexpr std::uint64_t kMaxSummaryBytes = 64u << 20;
constexpr std::uint64_t kMaxIndexBytes = 16u << 20;  // behind one chunk
constexpr std::size_t kMostDefinitions = 1000;
constexpr std::size_t kFooterBytes = 8 + 8 + 4;  // where the summary begins, where its offsets do, its CRC
constexpr std::size_t kIndexEntryBytes = 8 + 8;

struct Record {
  McapOp op = McapOp::kHeader;
  std::span<const std::byte> content;
};

std::optional<Record> take_record(ByteReader& reader) {
  const auto op = reader.little_endian<std::uint8_t>();
  const auto length = reader.little_endian<std::uint64_t>();
  if (!op || !length || *length > reader.remaining()) return std::nullopt;
  return Record{static_cast<McapOp>(*op), *reader.take(static_cast<std::size_t>(*length))};
}

/// A map of channels to numbers, after its length in bytes.
std::optional<std::vector<std::pair<std::uint16_t, std::uint64_t>>> take_numbers(ByteReader& reader) {
  constexpr std::size_t kPair = 2 + 8;
  const auto bytes = reader.little_endian<std::uint32_t>();
  const auto content = bytes ? reader.take(*bytes) : std::nullopt;
  if (!content || content->size() % kPair != 0) return std::nullopt;
  ByteReader pairs(*content);
  std::vector<std::pair<std::uint16_t, std::uint64_t>> numbers(content->size() / kPair);
  for (auto& [channel, number] : numbers) {
    channel = pairs.little_endian<std::uint16_t>().value_or(0);
    number = pairs.little_endian<std::uint64_t>().value_or(0);
  }
  return numbers;
}

std::optional<McapChunkPlace> parse_chunk_index(std::span<const std::byte> content) {
  ByteReader reader(content);
  (void)reader.take(8 + 8);  // earliest and latest time
  const auto begin = reader.little_endian<std::uint64_t>();
  const auto length = reader.little_endian<std::uint64_t>();
  auto indexes = take_numbers(reader);
  const auto index_length = reader.little_endian<std::uint64_t>();
  const auto compression = take_mcap_text(reader);
  (void)reader.little_endian<std::uint64_t>();  // the size as stored
  const auto unpacked = reader.little_endian<std::uint64_t>();
  if (!begin || !length || !indexes || !index_length || !compression || !unpacked) return std::nullopt;
  return McapChunkPlace{*begin, *length, *index_length, *unpacked, *std::move(indexes)};
}

std::optional<std::map<std::uint16_t, std::uint64_t>> parse_statistics(std::span<const std::byte> content) {
  ByteReader reader(content);
  // Counts of all messages, schemas, channels, attachments, metadata, chunks; earliest and latest time.
  if (!reader.take(8 + 2 + 4 + 4 + 4 + 4 + 8 + 8)) return std::nullopt;
  const auto counts = take_numbers(reader);
  if (!counts) return std::nullopt;
  return std::map<std::uint16_t, std::uint64_t>(counts->begin(), counts->end());
}

/// From the summary's beginning to the last magic; empty: there is none, or its CRC is wrong.
std::vector<std::byte> summary_bytes(const RandomAccess& file) {
  constexpr std::size_t kTail = kMcapRecordHeader + kFooterBytes + kMcapMagic.size();
  std::array<std::byte, kTail> tail{};
  if (file.size() < tail.size() || !file.read(file.size() - tail.size(), tail)) return {};
  ByteReader reader(tail);
  const auto op = reader.little_endian<std::uint8_t>();
  const auto length = reader.little_endian<std::uint64_t>();
  const auto begin = reader.little_endian<std::uint64_t>().value_or(0);
  (void)reader.little_endian<std::uint64_t>();
  const auto crc = reader.little_endian<std::uint32_t>().value_or(0);
  const std::uint64_t end = file.size() - tail.size();
  const bool is_footer = op == static_cast<std::uint8_t>(McapOp::kFooter) && length == kFooterBytes &&
                         std::equal(kMcapMagic.begin(), kMcapMagic.end(), tail.end() - kMcapMagic.size());
  if (!is_footer || begin == 0 || begin > end || end - begin > kMaxSummaryBytes) return {};
  std::vector<std::byte> bytes(static_cast<std::size_t>(end - begin));
  if (!file.read(begin, bytes)) return {};
  // The CRC is also of the footer up to itself.
  const auto head = std::span(tail).first(kMcapRecordHeader + 8 + 8);
  if (crc != 0 && crc32(head, crc32(bytes)) != crc) return {};
  return bytes;
}

}  // namespace

const McapChunkPlace* McapSummary::find_chunk(std::uint64_t begin) const {
  const auto found = std::lower_bound(chunks.begin(), chunks.end(), begin,
                                      [](const McapChunkPlace& chunk, std::uint64_t at) { return chunk.begin < at; });
  return found == chunks.end() || found->begin != begin ? nullptr : &*found;
}

std::optional<McapSummary> read_mcap_summary(const RandomAccess& file) {
  const auto bytes = summary_bytes(file);
  McapSummary summary;
  bool has_counts = false;
  for (ByteReader reader(bytes); reader.remaining() > 0;) {
    const auto record = take_record(reader);
    if (!record) return std::nullopt;
    if (record->op == McapOp::kSchema) {
      auto schema = parse_schema(record->content);
      if (!schema || summary.schemas.size() >= kMostDefinitions) return std::nullopt;
      summary.schemas.push_back(*std::move(schema));
    } else if (record->op == McapOp::kChannel) {
      auto channel = parse_channel(record->content);
      if (!channel || summary.channels.size() >= kMostDefinitions) return std::nullopt;
      summary.channels.push_back(*std::move(channel));
    } else if (record->op == McapOp::kChunkIndex) {
      auto chunk = parse_chunk_index(record->content);
      if (!chunk) return std::nullopt;
      summary.chunks.push_back(*std::move(chunk));
    } else if (record->op == McapOp::kStatistics) {
      auto messages = parse_statistics(record->content);
      if (!messages) return std::nullopt;
      summary.messages = *std::move(messages);
      has_counts = true;
    }
  }
  if (!has_counts || summary.chunks.empty()) return std::nullopt;
  std::sort(summary.chunks.begin(), summary.chunks.end(),
            [](const McapChunkPlace& a, const McapChunkPlace& b) { return a.begin < b.begin; });
  return summary;
}

std::optional<std::vector<McapIndexEntry>> read_message_indexes(const RandomAccess& file, const McapChunkPlace& chunk) {
  const std::uint64_t begin = chunk.begin + chunk.length;
  if (begin > file.size() || chunk.index_length > std::min(kMaxIndexBytes, file.size() - begin)) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(chunk.index_length));
  if (!file.read(begin, bytes)) return std::nullopt;
  auto missing = chunk.indexes;
  std::vector<McapIndexEntry> entries;
  for (ByteReader reader(bytes); reader.remaining() > 0;) {
    const std::uint64_t at = begin + reader.offset();
    const auto record = take_record(reader);
    if (!record || record->op != McapOp::kMessageIndex) return std::nullopt;
    ByteReader content(record->content);
    const auto channel = content.little_endian<std::uint16_t>();
    const auto size = content.little_endian<std::uint32_t>();
    if (!channel || !size || *size != content.remaining() || *size % kIndexEntryBytes != 0) return std::nullopt;
    const auto stated = std::find(missing.begin(), missing.end(), std::pair(*channel, at));
    if (stated == missing.end()) {
      if (*size == 0) continue;  // some writers have one for every channel
      return std::nullopt;
    }
    missing.erase(stated);
    while (content.remaining() > 0) {
      const auto log_ns = content.little_endian<std::uint64_t>().value_or(0);
      const auto offset = content.little_endian<std::uint64_t>().value_or(0);
      entries.push_back({*channel, log_ns, offset});
    }
  }
  if (!missing.empty()) return std::nullopt;
  std::sort(entries.begin(), entries.end(),
            [](const McapIndexEntry& a, const McapIndexEntry& b) { return a.offset < b.offset; });
  constexpr std::uint64_t kLeast = kMcapRecordHeader + kMcapMessageHeader;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::uint64_t end = i + 1 < entries.size() ? entries[i + 1].offset : chunk.unpacked;
    if (entries[i].offset > end || end - entries[i].offset < kLeast) return std::nullopt;
  }
  return entries;
}

}  // namespace scanknit
