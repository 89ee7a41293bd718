#include "acquire/mcap/mcap_writer.h"

#include <algorithm>
#include <string>
#include <utility>

#include "acquire/mcap/byte_appender.h"
#include "core/files/crc32.h"
#include "core/version.h"

namespace scanknit {
namespace {

// Opcode and length; earliest and latest time, size, CRC, an empty name of a compression, size again.
constexpr std::size_t kChunkHeader = kMcapRecordHeader + 8 + 8 + 8 + 4 + 4 + 8;

// `bytes` hold the summary and its offsets: the footer's CRC is of all that stands before it.
void append_footer(std::uint64_t summary_start, std::uint64_t offsets_start, std::vector<std::byte>& bytes) {
  ByteAppender writer(bytes);
  writer.little_endian(static_cast<std::uint8_t>(McapOp::kFooter));
  writer.little_endian(std::uint64_t{8 + 8 + 4});
  writer.little_endian(summary_start);
  writer.little_endian(offsets_start);
  writer.little_endian(crc32(bytes));
}

}  // namespace

McapWriter::McapWriter(ByteSink sink, std::vector<McapSchema> schemas, std::vector<McapChannel> channels,
                       std::string profile)
    : sink_(std::move(sink)),
      schemas_(std::move(schemas)),
      channels_(std::move(channels)),
      profile_(std::move(profile)) {
  begin_chunk();
}

Result<void> McapWriter::begin() {
  std::vector<std::byte> bytes(kMcapMagic.begin(), kMcapMagic.end());
  McapRecord header(McapOp::kHeader, bytes);
  ByteAppender writer(bytes);
  writer.text(profile_);
  writer.text(std::string("scanknit ") + kVersion);
  header.close();
  return write(bytes);
}

void McapWriter::begin_chunk() {
  chunk_.assign(kChunkHeader, std::byte{0});
  for (const McapSchema& schema : schemas_) append_schema(schema, chunk_);
  for (const McapChannel& channel : channels_) append_channel(channel, chunk_);
  messages_ = 0;
  index_.clear();
}

void McapWriter::add(const McapMessage& message) {
  begin_ns_ = messages_ == 0 ? message.log_ns : std::min(begin_ns_, message.log_ns);
  end_ns_ = messages_ == 0 ? message.log_ns : std::max(end_ns_, message.log_ns);
  ++messages_;
  index_[message.channel].push_back({message.log_ns, chunk_.size() - kChunkHeader});
  McapRecord record(McapOp::kMessage, chunk_);
  ByteAppender writer(chunk_);
  writer.little_endian(message.channel);
  writer.little_endian(message.sequence);
  writer.little_endian(message.log_ns);
  writer.little_endian(message.publish_ns);
  writer.append(message.data);
  record.close();
}

Result<void> McapWriter::flush() {
  if (messages_ == 0) return {};
  ChunkPlace place{.begin_ns = begin_ns_, .end_ns = end_ns_, .offset = offset_, .index_offsets = {}};
  close_chunk(place);
  append_message_indexes(place);
  auto written = write(chunk_);
  if (written) {
    for (const auto& [channel, entries] : index_) counts_[channel] += entries.size();
    places_.push_back(std::move(place));
  }
  begin_chunk();
  return written;
}

void McapWriter::close_chunk(ChunkPlace& place) {
  place.length = chunk_.size();
  place.records = chunk_.size() - kChunkHeader;
  std::vector<std::byte> header;
  ByteAppender writer(header);
  writer.little_endian(static_cast<std::uint8_t>(McapOp::kChunk));
  writer.little_endian(std::uint64_t{chunk_.size() - kMcapRecordHeader});
  writer.little_endian(place.begin_ns);
  writer.little_endian(place.end_ns);
  writer.little_endian(place.records);
  writer.little_endian(crc32(std::span(chunk_).subspan(kChunkHeader)));
  writer.text("");
  writer.little_endian(place.records);
  SCANKNIT_CHECK(header.size() == kChunkHeader);
  std::copy(header.begin(), header.end(), chunk_.begin());
}

void McapWriter::append_message_indexes(ChunkPlace& place) {
  for (const auto& [channel, entries] : index_) {
    place.index_offsets[channel] = place.offset + chunk_.size();
    McapRecord record(McapOp::kMessageIndex, chunk_);
    ByteAppender writer(chunk_);
    writer.little_endian(channel);
    writer.little_endian(static_cast<std::uint32_t>(entries.size() * 2 * sizeof(std::uint64_t)));
    for (const IndexEntry& entry : entries) {
      writer.little_endian(entry.log_ns);
      writer.little_endian(entry.offset);
    }
    record.close();
  }
  place.index_length = chunk_.size() - place.length;
}

Result<void> McapWriter::finish() {
  if (auto flushed = flush(); !flushed) return flushed;
  return write(summary());
}

// From DataEnd to the last magic: one piece, so that a file either has its summary or has not.
std::vector<std::byte> McapWriter::summary() const {
  std::vector<std::byte> bytes;
  McapRecord data_end(McapOp::kDataEnd, bytes);
  ByteAppender(bytes).little_endian(std::uint32_t{0});  // the chunks have their own CRCs
  data_end.close();
  const std::uint64_t begin = offset_ + bytes.size();

  std::vector<std::byte> section;
  std::vector<std::byte> offsets;
  const auto add_group = [&](McapOp op, std::size_t group_begin) {
    if (section.size() == group_begin) return;
    McapRecord record(McapOp::kSummaryOffset, offsets);
    ByteAppender writer(offsets);
    writer.little_endian(static_cast<std::uint8_t>(op));
    writer.little_endian(begin + group_begin);
    writer.little_endian(std::uint64_t{section.size() - group_begin});
    record.close();
  };
  std::size_t group = section.size();
  for (const McapSchema& schema : schemas_) append_schema(schema, section);
  add_group(McapOp::kSchema, group);
  group = section.size();
  for (const McapChannel& channel : channels_) append_channel(channel, section);
  add_group(McapOp::kChannel, group);
  group = section.size();
  append_statistics(section);
  add_group(McapOp::kStatistics, group);
  group = section.size();
  for (const ChunkPlace& place : places_) append_chunk_index(place, section);
  add_group(McapOp::kChunkIndex, group);

  const std::uint64_t offsets_start = begin + section.size();
  section.insert(section.end(), offsets.begin(), offsets.end());
  append_footer(begin, offsets_start, section);
  bytes.insert(bytes.end(), section.begin(), section.end());
  bytes.insert(bytes.end(), kMcapMagic.begin(), kMcapMagic.end());
  return bytes;
}

void McapWriter::append_chunk_index(const ChunkPlace& place, std::vector<std::byte>& bytes) const {
  McapRecord record(McapOp::kChunkIndex, bytes);
  ByteAppender writer(bytes);
  writer.little_endian(place.begin_ns);
  writer.little_endian(place.end_ns);
  writer.little_endian(place.offset);
  writer.little_endian(place.length);
  writer.little_endian(static_cast<std::uint32_t>(place.index_offsets.size() * (2 + 8)));
  for (const auto& [channel, offset] : place.index_offsets) {
    writer.little_endian(channel);
    writer.little_endian(offset);
  }
  writer.little_endian(place.index_length);
  writer.text("");
  writer.little_endian(place.records);
  writer.little_endian(place.records);
  record.close();
}

void McapWriter::append_statistics(std::vector<std::byte>& bytes) const {
  std::uint64_t messages = 0;
  for (const auto& [channel, count] : counts_) messages += count;
  std::uint64_t begin_ns = places_.empty() ? 0 : places_.front().begin_ns;
  std::uint64_t end_ns = 0;
  for (const ChunkPlace& place : places_) {
    begin_ns = std::min(begin_ns, place.begin_ns);
    end_ns = std::max(end_ns, place.end_ns);
  }
  McapRecord record(McapOp::kStatistics, bytes);
  ByteAppender writer(bytes);
  writer.little_endian(messages);
  writer.little_endian(static_cast<std::uint16_t>(schemas_.size()));
  writer.little_endian(static_cast<std::uint32_t>(channels_.size()));
  writer.little_endian(std::uint32_t{0});  // attachments
  writer.little_endian(std::uint32_t{0});  // metadata
  writer.little_endian(static_cast<std::uint32_t>(places_.size()));
  writer.little_endian(begin_ns);
  writer.little_endian(end_ns);
  writer.little_endian(static_cast<std::uint32_t>(counts_.size() * (2 + 8)));
  for (const auto& [channel, count] : counts_) {
    writer.little_endian(channel);
    writer.little_endian(count);
  }
  record.close();
}

Result<void> McapWriter::write(std::span<const std::byte> bytes) {
  auto written = sink_(bytes);
  if (written) offset_ += bytes.size();
  return written;
}

}  // namespace scanknit
