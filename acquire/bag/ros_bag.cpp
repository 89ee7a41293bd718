#include "acquire/bag/ros_bag.h"

#include <bzlib.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "acquire/mcap/lz4_bytes.h"
#include "core/checked_math.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMaxHeaderBytes = 1u << 16;
constexpr std::uint32_t kMaxDescriptionBytes = 1u << 20;  // of a connection, with the text of its type
constexpr std::uint8_t kMessageOp = 0x02, kBagHeaderOp = 0x03, kChunkOp = 0x05, kChunkInfoOp = 0x06,
                       kConnectionOp = 0x07;

using Fields = std::map<std::string, std::span<const std::byte>>;

std::string text_of(std::span<const std::byte> bytes) {
  std::string text(bytes.size(), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) text[i] = static_cast<char>(bytes[i]);
  return text;
}

// Pairs of "name=value", each after its length in 32 bits.
std::optional<Fields> parse_fields(std::span<const std::byte> header) {
  Fields fields;
  ByteReader reader(header);
  while (reader.remaining() > 0) {
    const auto length = reader.little_endian<std::uint32_t>();
    const auto field = length ? reader.take(*length) : std::nullopt;
    if (!field) return std::nullopt;
    const auto equals = std::find(field->begin(), field->end(), std::byte{'='});
    if (equals == field->end()) return std::nullopt;
    const auto name = static_cast<std::size_t>(equals - field->begin());
    fields[text_of(field->first(name))] = field->subspan(name + 1);
  }
  return fields;
}

template <typename T>
std::optional<T> number_in(const Fields& fields, const char* name) {
  const auto field = fields.find(name);
  if (field == fields.end() || field->second.size() != sizeof(T)) return std::nullopt;
  return ByteReader(field->second).little_endian<T>();
}

std::string text_in(const Fields& fields, const char* name) {
  const auto field = fields.find(name);
  return field == fields.end() ? std::string() : text_of(field->second);
}

bool unpack_bz2(std::span<const std::byte> packed, std::span<std::byte> bytes) {
  std::vector<char> source(packed.size());  // the library's parameter is not const
  std::transform(packed.begin(), packed.end(), source.begin(), [](std::byte b) { return static_cast<char>(b); });
  std::vector<char> target(bytes.size());
  auto size = static_cast<unsigned>(target.size());
  const int status =
      BZ2_bzBuffToBuffDecompress(target.data(), &size, source.data(), static_cast<unsigned>(source.size()), 0, 0);
  if (status != BZ_OK || size != bytes.size()) return false;
  std::transform(target.begin(), target.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return true;
}

}  // namespace

bool is_ros_bag(const RandomAccess& file) {
  std::array<std::byte, kMagic.size()> magic{};
  return file.read(0, magic) && text_of(magic) == kMagic;
}

Result<RosBag> RosBag::open(std::unique_ptr<RandomAccess> file, const Limits& limits) {
  if (!is_ros_bag(*file)) return Error{ErrorCode::kInput, "not a bag of ROS 1, version 2.0"};
  RosBag bag(std::move(file), limits);
  if (const auto walked = bag.walk(); !walked) return walked.error();
  return bag;
}

std::optional<std::vector<BagConnection>> RosBag::indexed_connections(std::unique_ptr<RandomAccess> file,
                                                                      const Limits& limits) {
  if (!is_ros_bag(*file)) return std::nullopt;
  RosBag bag(std::move(file), limits);
  std::uint64_t at = kMagic.size();
  if (bag.walk_record(at) != RecordState::kWhole) return std::nullopt;
  const std::uint64_t size = bag.file_->size();
  if (bag.index_begin_ < at || bag.index_begin_ >= size) return std::nullopt;
  const bool is_whole = bag.walk_records(*bag.file_, bag.index_begin_, size);
  if (!is_whole || bag.connections_.size() < bag.promised_connections_) return std::nullopt;
  return std::move(bag.connections_);
}

Result<void> RosBag::walk() {
  std::uint64_t at = kMagic.size();
  while (at < file_->size()) {
    const std::uint64_t begin = at;
    const RecordState state = walk_record(at);
    if (state != RecordState::kWhole) {
      fault_ = describe_end(state, begin);
      return {};
    }
    if (messages_.size() > limits_.max_frames) {
      return Error{ErrorCode::kInput, "more messages than " + std::to_string(limits_.max_frames)};
    }
  }
  const bool has_index = is_finished_.value_or(false) && index_records_ >= promised_index_records_;
  if (!has_index) fault_ = describe_end(RecordState::kWhole, at);
  return {};
}

// Why nothing is read from byte `begin` on: a record of this state begins there (kWhole: none).
std::string RosBag::describe_end(RecordState state, std::uint64_t begin) const {
  const std::string at = std::to_string(begin);
  const std::string size = std::to_string(file_->size());
  if (is_finished_ == false) {
    return "the program that recorded it has not finished it, and it can be read up to byte " + at + " of " + size;
  }
  switch (state) {
    case RecordState::kWhole: return "it is cut off at byte " + size + ", before the end of its index";
    case RecordState::kCut: return "it is cut off at byte " + size + ", within the record at byte " + at;
    case RecordState::kDamaged: break;
  }
  return "it is damaged at byte " + at + " of " + size;
}

// The record at `at`, which then is its end. Of those outside of chunks only chunks matter: connections are repeated in
// them. The rest is counted.
RosBag::RecordState RosBag::walk_record(std::uint64_t& at) {
  const auto take_length = [&]() -> std::optional<std::uint32_t> {
    std::array<std::byte, sizeof(std::uint32_t)> raw{};
    if (!file_->read(at, raw)) return std::nullopt;
    at += raw.size();
    return ByteReader(raw).little_endian<std::uint32_t>();
  };
  const auto header_length = take_length();
  if (!header_length) return RecordState::kCut;
  if (*header_length > kMaxHeaderBytes) return RecordState::kDamaged;
  std::vector<std::byte> header(*header_length);
  if (!file_->read(at, header)) return RecordState::kCut;
  at += header.size();
  const auto fields = parse_fields(header);
  if (!fields) return RecordState::kDamaged;
  const auto length = take_length();
  if (!length || *length > file_->size() - at) return RecordState::kCut;
  const std::uint64_t begin = at;
  at += *length;
  const auto op = number_in<std::uint8_t>(*fields, "op");
  if (op == kBagHeaderOp) {
    index_begin_ = number_in<std::uint64_t>(*fields, "index_pos").value_or(0);
    is_finished_ = index_begin_ != 0;
    promised_connections_ = number_in<std::uint32_t>(*fields, "conn_count").value_or(0);
    promised_index_records_ = promised_connections_ + number_in<std::uint32_t>(*fields, "chunk_count").value_or(0);
  }
  if (op == kConnectionOp || op == kChunkInfoOp) ++index_records_;
  if (op != kChunkOp) return RecordState::kWhole;
  const auto unpacked = number_in<std::uint32_t>(*fields, "size");
  if (!unpacked) return RecordState::kDamaged;
  chunks_.push_back({begin, *length, *unpacked, text_in(*fields, "compression")});
  if (!walk_chunk(chunks_.back())) {
    if (!fault_) fault_ = "the chunk at byte " + std::to_string(begin) + " is damaged or compressed in an unknown way";
  }
  return RecordState::kWhole;
}

// A chunk that is not compressed is not read whole.
bool RosBag::walk_chunk(const Chunk& chunk) {
  if (chunk.compression == "none" && chunk.packed == chunk.unpacked) {
    return walk_records(*file_, chunk.begin, chunk.begin + chunk.packed);
  }
  const auto bytes = load(chunk);
  return bytes && walk_records(MemoryAccess(*bytes), 0, bytes->size());
}

bool RosBag::walk_records(const RandomAccess& bytes, std::uint64_t begin, std::uint64_t end) {
  const auto take = [&](std::uint64_t& at, std::uint32_t most) -> std::optional<std::vector<std::byte>> {
    std::array<std::byte, sizeof(std::uint32_t)> raw{};
    if (end - at < raw.size() || !bytes.read(at, raw)) return std::nullopt;
    const auto length = ByteReader(raw).little_endian<std::uint32_t>().value_or(0);
    at += raw.size();
    if (length > end - at) return std::nullopt;
    std::vector<std::byte> field(std::min(length, most));
    if (!bytes.read(at, field)) return std::nullopt;
    at += length;
    return field;
  };
  for (std::uint64_t at = begin; at < end && messages_.size() <= limits_.max_frames;) {
    const auto header = take(at, kMaxHeaderBytes);
    const auto fields = header ? parse_fields(*header) : std::nullopt;
    if (!fields) return false;
    const auto op = number_in<std::uint8_t>(*fields, "op");
    const std::uint64_t offset = at - begin + sizeof(std::uint32_t);
    const auto data = take(at, op == kConnectionOp ? kMaxDescriptionBytes : 0);
    const auto id = number_in<std::uint32_t>(*fields, "conn");
    if (!data) return false;
    if (op == kConnectionOp && id) {
      note_connection(*id, text_in(*fields, "topic"), *data);
    } else if (op == kMessageOp && id) {
      // Seconds and nanoseconds, 32 bits each.
      const auto time = number_in<std::uint64_t>(*fields, "time");
      if (!time) return false;
      const auto time_ns = static_cast<std::int64_t>((*time & 0xFFFF'FFFF) * 1'000'000'000 + (*time >> 32));
      messages_.push_back({*id, time_ns, static_cast<std::uint32_t>(chunks_.size() - 1),
                           static_cast<std::size_t>(offset), static_cast<std::size_t>(at - begin - offset)});
    }
  }
  return true;
}

// Later ones only repeat the first.
void RosBag::note_connection(std::uint32_t id, std::string topic, std::span<const std::byte> description) {
  const auto fields = parse_fields(description);
  const auto has_id = [&](const BagConnection& connection) { return connection.id == id; };
  if (!fields || std::any_of(connections_.begin(), connections_.end(), has_id)) return;
  connections_.push_back({id, std::move(topic), text_in(*fields, "type")});
}

std::optional<std::vector<std::byte>> RosBag::load(const Chunk& chunk) const {
  if (std::max(chunk.packed, chunk.unpacked) > limits_.max_image_bytes) return std::nullopt;
  std::vector<std::byte> packed(chunk.packed);
  if (!file_->read(chunk.begin, packed)) return std::nullopt;
  if (chunk.compression == "none") {
    if (chunk.packed != chunk.unpacked) return std::nullopt;
    return packed;
  }
  if (chunk.compression == "lz4") {
    auto bytes = lz4_unpack(packed, chunk.unpacked);
    return bytes ? std::optional(*std::move(bytes)) : std::nullopt;
  }
  std::vector<std::byte> bytes(chunk.unpacked);
  if (chunk.compression != "bz2" || !unpack_bz2(packed, bytes)) return std::nullopt;
  return bytes;
}

Result<std::span<const std::byte>> RosBag::read(const BagMessage& message) {
  const Error changed{ErrorCode::kInput, "the file has changed while it was read"};
  const Chunk& chunk = chunks_[message.chunk];
  if (chunk.compression == "none") {
    if (message.length > limits_.max_image_bytes) {
      return Error{ErrorCode::kInput, "a message has more bytes than " + std::to_string(limits_.max_image_bytes)};
    }
    alone_.resize(message.length);
    if (!file_->read(chunk.begin + message.offset, alone_)) return changed;
    return std::span<const std::byte>(alone_);
  }
  LoadedChunk* place = &cache_[0];
  for (LoadedChunk& candidate : cache_) {
    if (candidate.bytes && candidate.index == message.chunk) {
      place = &candidate;
      break;
    }
    if (candidate.used < place->used) place = &candidate;
  }
  place->used = ++reads_;
  if (!place->bytes || place->index != message.chunk) {
    place->bytes.reset();  // before the next one is read: two chunks are enough
    place->index = message.chunk;
    place->bytes = load(chunk);
  }
  if (!place->bytes) return changed;
  ByteReader reader(*place->bytes);
  if (!reader.take(message.offset)) return changed;
  const auto data = reader.take(message.length);
  if (!data) return changed;
  return *data;
}

bool RosBag::peek(const BagMessage& message, std::span<std::byte> to) {
  if (to.size() > message.length) return false;
  const Chunk& chunk = chunks_[message.chunk];
  if (chunk.compression == "none") return file_->read(chunk.begin + message.offset, to);
  const auto data = read(message);
  if (!data) return false;
  std::copy_n(data->begin(), to.size(), to.begin());
  return true;
}

}  // namespace scanknit
