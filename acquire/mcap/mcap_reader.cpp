#include "acquire/mcap/mcap_reader.h"

#include <algorithm>
#include <utility>

#include "acquire/mcap/lz4_bytes.h"
#include "acquire/mcap/zstd_bytes.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"
#include "core/files/crc32.h"

namespace scanknit {
namespace {

constexpr std::size_t kFixedChunkHeader = 8 + 8 + 8 + 4 + 4;  // up to the length of the compression's name
constexpr std::size_t kLongestCompression = 4;                // "zstd"
constexpr std::uint64_t kMaxDefinitionBytes = 1u << 20;       // a schema or a channel
constexpr std::size_t kMaxDefinitions = 1000;                 // ours have ten

// What the specification does not know, nobody wrote.
bool is_expected(McapOp op) {
  return op >= McapOp::kHeader && op <= McapOp::kDataEnd;
}

// The specification leaves these to applications and asks readers to skip them.
bool is_private(McapOp op) {
  return static_cast<std::uint8_t>(op) >= 0x80;
}

std::string at_byte(std::uint64_t offset) {
  return "at byte " + std::to_string(offset);
}

}  // namespace

bool is_mcap(const RandomAccess& file) {
  std::array<std::byte, kMcapMagic.size()> magic{};
  return file.read(0, magic) && magic == kMcapMagic;
}

std::string mcap_profile(const RandomAccess& file) {
  constexpr std::size_t kLongest = 64;
  std::array<std::byte, kMcapMagic.size() + kMcapRecordHeader + sizeof(std::uint32_t) + kLongest> front{};
  const auto bytes = std::span(front).first(std::min<std::uint64_t>(front.size(), file.size()));
  if (!is_mcap(file) || !file.read(0, bytes)) return {};
  ByteReader reader(bytes);
  (void)reader.take(kMcapMagic.size());
  const auto op = reader.little_endian<std::uint8_t>();
  const auto length = reader.little_endian<std::uint64_t>();
  if (op != static_cast<std::uint8_t>(McapOp::kHeader) || !length) return {};
  return take_mcap_text(reader).value_or(std::string());
}

Result<McapReader> McapReader::open(std::unique_ptr<RandomAccess> file, const Limits& limits, McapIndexUse use) {
  if (!is_mcap(*file)) return Error{ErrorCode::kInput, "not an MCAP file (version 0)"};
  McapReader reader(std::move(file), limits);
  const auto walked = use == McapIndexUse::kNone ? reader.walk_file() : reader.walk_with_index();
  if (!walked) return walked.error();
  return reader;
}

const McapChannel* McapReader::find_channel(std::string_view topic) const {
  const auto found = std::find_if(channels_.begin(), channels_.end(),
                                  [&](const McapChannel& channel) { return channel.topic == topic; });
  return found == channels_.end() ? nullptr : &*found;
}

std::optional<McapReader::Record> McapReader::record_at(const RandomAccess& bytes, std::uint64_t at,
                                                        std::uint64_t end) {
  std::array<std::byte, kMcapRecordHeader> header{};
  if (end - at < header.size() || !bytes.read(at, header)) return std::nullopt;
  ByteReader reader(header);
  const auto op = reader.little_endian<std::uint8_t>().value_or(0);
  const auto length = reader.little_endian<std::uint64_t>().value_or(0);
  const std::uint64_t begin = at + header.size();
  if (length > end - begin) return std::nullopt;
  return Record{static_cast<McapOp>(op), begin, length};
}

Result<void> McapReader::walk_file() {
  const std::uint64_t size = file_->size();
  std::uint64_t at = kMcapMagic.size();
  std::uint64_t after_chunk = at;  // what lies between is known by its length alone
  while (at < size) {
    const auto record = record_at(*file_, at, size);
    bool is_good = record && (is_expected(record->op) || is_private_record(*record));
    if (is_good && (record->op == McapOp::kDataEnd || record->op == McapOp::kFooter)) {
      std::array<std::byte, kMcapMagic.size()> end{};
      const bool is_whole = file_->read(size - end.size(), end) && end == kMcapMagic;
      if (!is_whole) note_fault("its index is cut off");
      return {};
    }
    if (is_good && record->op == McapOp::kChunk) {
      const auto walked = walk_chunk(*record);
      if (!walked) return walked.error();
      is_good = *walked;
      after_chunk = is_good ? record->end() : at + 1;
    } else if (is_good && record->op == McapOp::kMessage) {
      const auto walked = walk_message(*record);
      if (!walked) return walked.error();
      is_good = *walked;
    } else if (is_good) {
      note_definition(*file_, *record);
    }
    if (is_good) {
      at = record->end();
      continue;
    }
    note_fault("it ends early or is damaged " + at_byte(at) + " of " + std::to_string(size));
    // A length may be what is damaged: the next chunk is where one is found. Where messages lie bare there is none.
    const bool has_bare_messages = !has_chunks_ && !messages_.empty();
    const auto next = has_bare_messages ? std::nullopt : find_chunk(after_chunk);
    if (!next) return {};
    at = *next;
  }
  note_fault("it ends early: " + at_byte(at) + " of " + std::to_string(size));
  return {};
}

// No chunk or message with a damaged opcode, which must not be passed over in silence; and a record follows it.
bool McapReader::is_private_record(const Record& record) const {
  if (!is_private(record.op) || parse_chunk(record)) return false;
  std::array<std::byte, sizeof(std::uint16_t)> front{};
  if (!has_chunks_ && record.length >= kMcapMessageHeader && file_->read(record.begin, front)) {
    const auto id = ByteReader(front).little_endian<std::uint16_t>();
    if (std::any_of(channels_.begin(), channels_.end(), [&](const auto& channel) { return channel.id == id; })) {
      return false;
    }
  }
  const auto next = record_at(*file_, record.end(), file_->size());
  return next && (is_expected(next->op) || is_private(next->op));
}

std::optional<std::uint64_t> McapReader::find_chunk(std::uint64_t from) {
  constexpr std::size_t kBlock = 1u << 16;
  std::vector<std::byte> block(kBlock + kMcapRecordHeader);
  const std::uint64_t size = file_->size();
  for (std::uint64_t at = file_->next_data(from); at < size; at = file_->next_data(at + kBlock)) {
    const auto bytes =
        std::span(block).first(static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), size - at)));
    if (!file_->read(at, bytes)) return std::nullopt;
    for (std::size_t i = 0; i < std::min(kBlock, bytes.size()); ++i) {
      if (bytes[i] == static_cast<std::byte>(McapOp::kChunk) && is_whole_chunk(at + i)) return at + i;
    }
  }
  return std::nullopt;
}

bool McapReader::is_whole_chunk(std::uint64_t at) {
  constexpr std::uint64_t kLargest = 16u << 20;  // ours have a mebibyte
  constexpr int kMostTrials = 1000;              // so that no file makes us unpack for ever
  const auto record = record_at(*file_, at, file_->size());
  if (!record || record->op != McapOp::kChunk || record->length > kLargest) return false;
  const auto chunk = parse_chunk(*record);
  const bool is_likely = chunk && chunk->crc != 0 && chunk->unpacked <= kLargest &&
                         chunk->begin + chunk->length == record->end() && ++trials_ <= kMostTrials;
  return is_likely && load(*chunk);
}

Result<bool> McapReader::walk_chunk(const Record& record) {
  const auto chunk = parse_chunk(record);
  if (!chunk) {
    note_fault("the chunk " + at_byte(record.begin) + " is malformed or compressed in an unknown way");
    return false;
  }
  chunks_.push_back(*chunk);
  has_chunks_ = true;
  if (note_indexed(record, *chunk)) {
    if (const auto counted = check_count(); !counted) return counted.error();
    return true;
  }
  const std::size_t known_schemas = schemas_.size();
  const std::size_t known_channels = channels_.size();
  bool is_whole = false;
  if (chunk->packing != Packing::kNone) {
    const auto records = load(*chunk);
    is_whole = records && walk_records(MemoryAccess(*records), 0, records->size());
  } else {
    is_whole = walk_records(*file_, chunk->begin, chunk->begin + chunk->length);
  }
  // What is new must be true, since later chunks only repeat it: the first chunk is read whole for that.
  const bool has_new = schemas_.size() > known_schemas || channels_.size() > known_channels;
  if (has_new && !load(*chunk)) {
    is_whole = false;
    schemas_.resize(known_schemas);
    channels_.resize(known_channels);
  }
  if (!is_whole) note_fault("the chunk " + at_byte(record.begin) + " is damaged");
  if (const auto counted = check_count(); !counted) return counted.error();
  return is_whole;
}

// It has no checksum, and none of ours is written so: only a file without a single chunk has such messages, of channels
// that came before.
Result<bool> McapReader::walk_message(const Record& record) {
  if (has_chunks_) return false;
  chunks_.push_back({.begin = record.begin, .length = record.length, .unpacked = record.length});
  const bool is_whole = note_message(*file_, record, record.begin);
  const bool is_known = is_whole && std::any_of(channels_.begin(), channels_.end(), [&](const McapChannel& channel) {
                          return channel.id == messages_.back().channel;
                        });
  if (is_whole && !is_known) messages_.pop_back();
  if (!is_known) chunks_.pop_back();
  if (const auto counted = check_count(); !counted) return counted.error();
  return is_known;
}

Result<void> McapReader::check_count() const {
  if (messages_.size() <= limits_.max_frames) return {};
  return Error{ErrorCode::kInput, "more messages than " + std::to_string(limits_.max_frames)};
}

bool McapReader::walk_records(const RandomAccess& bytes, std::uint64_t begin, std::uint64_t end) {
  for (std::uint64_t at = begin; at < end;) {
    const auto record = record_at(bytes, at, end);
    if (!record || messages_.size() > limits_.max_frames) return false;
    if (record->op == McapOp::kMessage) {
      if (!note_message(bytes, *record, begin)) return false;
    } else {
      note_definition(bytes, *record);
    }
    at = record->end();
  }
  return true;
}

bool McapReader::note_message(const RandomAccess& bytes, const Record& record, std::uint64_t base) {
  std::array<std::byte, kMcapMessageHeader> header{};
  if (record.length < header.size() || !bytes.read(record.begin, header)) return false;
  ByteReader reader(header);
  McapMessagePlace message;
  message.channel = reader.little_endian<std::uint16_t>().value_or(0);
  message.sequence = reader.little_endian<std::uint32_t>().value_or(0);
  message.log_ns = reader.little_endian<std::uint64_t>().value_or(0);
  message.publish_ns = reader.little_endian<std::uint64_t>().value_or(0);
  message.chunk = static_cast<std::uint32_t>(chunks_.size() - 1);
  message.offset = record.begin - base + header.size();
  message.length = record.length - header.size();
  messages_.push_back(message);
  return true;
}

// A schema or channel that is not known yet; every other record is passed over.
void McapReader::note_definition(const RandomAccess& bytes, const Record& record) {
  const bool is_schema = record.op == McapOp::kSchema && schemas_.size() < kMaxDefinitions;
  const bool is_channel = record.op == McapOp::kChannel && channels_.size() < kMaxDefinitions;
  if ((!is_schema && !is_channel) || record.length > kMaxDefinitionBytes) return;
  std::vector<std::byte> content(static_cast<std::size_t>(record.length));
  if (!bytes.read(record.begin, content)) return;
  const auto add_new = [](auto definition, auto& known) {
    if (!definition) return;
    const auto has_id = [&](const auto& other) { return other.id == definition->id; };
    if (std::none_of(known.begin(), known.end(), has_id)) known.push_back(*std::move(definition));
  };
  if (is_schema) add_new(parse_schema(content), schemas_);
  if (is_channel) add_new(parse_channel(content), channels_);
}

std::optional<McapReader::Chunk> McapReader::parse_chunk(const Record& record) const {
  std::array<std::byte, kFixedChunkHeader> fixed{};
  if (record.length < fixed.size() || !file_->read(record.begin, fixed)) return std::nullopt;
  ByteReader reader(fixed);
  (void)reader.take(8 + 8);  // earliest and latest time
  Chunk chunk;
  chunk.unpacked = reader.little_endian<std::uint64_t>().value_or(0);
  chunk.crc = reader.little_endian<std::uint32_t>().value_or(0);
  const std::uint32_t name_length = reader.little_endian<std::uint32_t>().value_or(0);
  if (name_length > kLongestCompression) return std::nullopt;
  std::vector<std::byte> rest(name_length + sizeof(std::uint64_t));
  if (record.length - fixed.size() < rest.size() || !file_->read(record.begin + fixed.size(), rest)) {
    return std::nullopt;
  }
  ByteReader rest_reader(rest);
  std::string name;
  for (std::uint32_t i = 0; i < name_length; ++i) name += rest_reader.little_endian<char>().value_or('\0');
  if (name == "zstd") {
    chunk.packing = Packing::kZstd;
  } else if (name == "lz4") {
    chunk.packing = Packing::kLz4;
  } else if (!name.empty()) {
    return std::nullopt;
  }
  chunk.length = rest_reader.little_endian<std::uint64_t>().value_or(0);
  chunk.begin = record.begin + fixed.size() + rest.size();
  if (chunk.length > record.end() - chunk.begin) return std::nullopt;
  if (chunk.packing == Packing::kNone && chunk.unpacked != chunk.length) return std::nullopt;
  return chunk;
}

Result<std::vector<std::byte>> McapReader::load(const Chunk& chunk) const {
  const std::string where = "the chunk " + at_byte(chunk.begin);
  const auto stored = checked_narrow<std::size_t>(chunk.length);
  const auto unpacked = checked_narrow<std::size_t>(chunk.unpacked);
  if (!stored || !unpacked || std::max(chunk.length, chunk.unpacked) > limits_.max_image_bytes) {
    return Error{ErrorCode::kInput, where + " has more bytes than " + std::to_string(limits_.max_image_bytes)};
  }
  std::vector<std::byte> records(*stored);
  if (!file_->read(chunk.begin, records)) return Error{ErrorCode::kInput, where + " cannot be read"};
  if (chunk.packing != Packing::kNone) {
    auto plain = chunk.packing == Packing::kZstd ? zstd_unpack(records, *unpacked) : lz4_unpack(records, *unpacked);
    if (!plain) return Error{ErrorCode::kInput, where + ": " + plain.error().message};
    records = *std::move(plain);
  }
  if (chunk.crc != 0 && crc32(records) != chunk.crc) {
    return Error{ErrorCode::kInput, where + " is damaged: its checksum is wrong"};
  }
  return records;
}

const Result<std::vector<std::byte>>& McapReader::loaded(std::uint32_t index) {
  LoadedChunk* place = &cache_[0];
  for (LoadedChunk& candidate : cache_) {
    if (candidate.records && candidate.index == index) {
      candidate.used = ++reads_;
      return *candidate.records;
    }
    if (candidate.used < place->used) place = &candidate;
  }
  place->index = index;
  place->used = ++reads_;
  place->records.reset();  // before the next one is read: two chunks are enough
  const Chunk& chunk = chunks_[index];
  place->records.emplace(load(chunk));
  if (chunk.is_indexed && (!*place->records || !is_as_indexed(chunk, **place->records))) {
    is_index_wrong_ = true;
    place->records.emplace(Error{ErrorCode::kInput, "the index does not fit the chunk " + at_byte(chunk.begin)});
  }
  return *place->records;
}

Result<std::span<const std::byte>> McapReader::read(const McapMessagePlace& message) {
  SCANKNIT_CHECK(message.chunk < chunks_.size());
  const auto& records = loaded(message.chunk);
  if (!records) return records.error();
  ByteReader reader(*records);
  if (!checked_narrow<std::size_t>(message.offset) || !reader.take(static_cast<std::size_t>(message.offset))) {
    return Error{ErrorCode::kInput, "the file has changed while it was read"};
  }
  std::uint64_t length = message.length;
  if (chunks_[message.chunk].is_indexed) {
    // The index does not say it; the record, which has been checked, does.
    const auto head = std::span(*records).first(static_cast<std::size_t>(message.offset));
    ByteReader before(head.last(kMcapMessageHeader + sizeof(std::uint64_t)));
    length = before.little_endian<std::uint64_t>().value_or(0) - kMcapMessageHeader;
  }
  const auto data = reader.take(static_cast<std::size_t>(length));
  if (!data) return Error{ErrorCode::kInput, "the file has changed while it was read"};
  return *data;
}

Result<std::span<const std::byte>> McapReader::read_alone(const McapMessagePlace& message) {
  SCANKNIT_CHECK(message.chunk < chunks_.size());
  constexpr std::uint64_t kSmall = 1u << 16;
  constexpr std::uint64_t kLarge = 1u << 18;
  const Chunk& chunk = chunks_[message.chunk];
  const bool is_alone = chunk.packing == Packing::kNone && message.length <= kSmall && chunk.length >= kLarge;
  if (!is_alone) return read(message);
  alone_.resize(static_cast<std::size_t>(message.length));
  if (!file_->read(chunk.begin + message.offset, alone_)) {
    return Error{ErrorCode::kInput, "the file has changed while it was read"};
  }
  return std::span<const std::byte>(alone_);
}

bool McapReader::peek(const McapMessagePlace& message, std::span<std::byte> to) {
  SCANKNIT_CHECK(message.chunk < chunks_.size());
  const Chunk& chunk = chunks_[message.chunk];
  if (!chunk.is_indexed && to.size() > message.length) return false;
  if (chunk.packing == Packing::kNone) return file_->read(chunk.begin + message.offset, to);
  const auto data = read(message);
  if (!data || data->size() < to.size()) return false;
  std::copy_n(data->begin(), to.size(), to.begin());
  return true;
}

void McapReader::note_fault(std::string text) {
  if (!fault_) fault_ = std::move(text);
}

}  // namespace scanknit
