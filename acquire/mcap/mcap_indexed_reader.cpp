// McapReader where the file has an index: the messages of compressed chunks are found without unpacking these.
#include <algorithm>
#include <map>
#include <utility>

#include "acquire/mcap/mcap_reader.h"
#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

/// Those of `more` whose ids are not there yet.
template <typename Definition>
void add_new(const std::vector<Definition>& more, std::vector<Definition>& known) {
  for (const Definition& definition : more) {
    const auto has_id = [&](const Definition& other) { return other.id == definition.id; };
    if (std::none_of(known.begin(), known.end(), has_id)) known.push_back(definition);
  }
}

}  // namespace

Result<void> McapReader::walk_with_index() {
  summary_ = read_mcap_summary(*file_);
  if (auto walked = walk_file(); !walked) return walked;
  if (indexed_bytes_ > 0) {
    if (fault_ || !is_count_as_stated()) return walk_without_index();
    add_new(summary_->schemas, schemas_);
    add_new(summary_->channels, channels_);
  }
  summary_.reset();  // it is not needed any more
  return {};
}

Result<void> McapReader::walk_without_index() {
  summary_.reset();
  schemas_.clear();
  channels_.clear();
  chunks_.clear();
  messages_.clear();
  fault_.reset();
  for (LoadedChunk& loaded : cache_) loaded = {};
  indexed_bytes_ = 0;
  is_index_wrong_ = false;
  has_chunks_ = false;
  trials_ = 0;
  return walk_file();
}

Result<bool> McapReader::drop_wrong_index() {
  if (!is_index_wrong_) return false;
  if (const auto walked = walk_without_index(); !walked) return walked.error();
  return true;
}

bool McapReader::note_indexed(const Record& record, const Chunk& chunk) {
  const McapChunkPlace* place = summary_ ? summary_->find_chunk(record.begin - kMcapRecordHeader) : nullptr;
  const bool is_stated = place != nullptr && chunk.packing != Packing::kNone &&
                         place->length == record.length + kMcapRecordHeader && place->unpacked == chunk.unpacked &&
                         chunk.unpacked <= limits_.max_image_bytes;
  const auto entries = is_stated ? read_message_indexes(*file_, *place) : std::nullopt;
  if (!entries || entries->size() > limits_.max_frames) return false;
  Chunk& noted = chunks_.back();
  noted.is_indexed = true;
  noted.first_message = messages_.size();
  noted.messages = entries->size();
  for (const McapIndexEntry& entry : *entries) {
    McapMessagePlace message;
    message.channel = entry.channel;
    message.log_ns = entry.log_ns;
    message.chunk = static_cast<std::uint32_t>(chunks_.size() - 1);
    message.offset = entry.offset + kMcapRecordHeader + kMcapMessageHeader;
    messages_.push_back(message);
  }
  indexed_bytes_ += chunk.length;
  return true;
}

bool McapReader::is_count_as_stated() const {
  std::map<std::uint16_t, std::uint64_t> counts;
  for (const McapMessagePlace& message : messages_) ++counts[message.channel];
  std::map<std::uint16_t, std::uint64_t> stated = summary_->messages;
  std::erase_if(stated, [](const auto& count) { return count.second == 0; });
  return counts == stated;
}

// The records of a chunk hold the messages that the index tells, no others, and define nothing anew.
bool McapReader::is_as_indexed(const Chunk& chunk, std::span<const std::byte> records) const {
  const MemoryAccess bytes(records);
  std::size_t next = chunk.first_message;
  const std::size_t end = chunk.first_message + chunk.messages;
  const auto knows = [](const auto& definition, const auto& known) {
    return definition && std::find(known.begin(), known.end(), *definition) != known.end();
  };
  for (std::uint64_t at = 0; at < records.size();) {
    const auto record = record_at(bytes, at, records.size());
    if (!record) return false;
    const auto content =
        records.subspan(static_cast<std::size_t>(record->begin), static_cast<std::size_t>(record->length));
    if (record->op == McapOp::kSchema && !knows(parse_schema(content), schemas_)) return false;
    if (record->op == McapOp::kChannel && !knows(parse_channel(content), channels_)) return false;
    if (record->op == McapOp::kMessage) {
      ByteReader reader(content);
      const auto channel = reader.little_endian<std::uint16_t>();
      (void)reader.little_endian<std::uint32_t>();
      const auto log_ns = reader.little_endian<std::uint64_t>();
      if (next == end || content.size() < kMcapMessageHeader) return false;
      const McapMessagePlace& message = messages_[next++];
      const bool is_same = message.channel == channel && message.log_ns == log_ns &&
                           message.offset == record->begin + kMcapMessageHeader;
      if (!is_same) return false;
    }
    at = record->end();
  }
  return next == end;
}

}  // namespace scanknit
