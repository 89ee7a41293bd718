// McapWriter: messages in chunks that stand for themselves, each handed on in one piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "core/result.h"

namespace scanknit {

/// Takes all bytes or none, at the end of what it took before.
using ByteSink = std::function<Result<void>(std::span<const std::byte>)>;

struct McapMessage {
  std::uint16_t channel = 0;  ///< one of the writer's
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;
  std::uint64_t publish_ns = 0;
  std::span<const std::byte> data;
};

/// Every chunk repeats the schemas and channels, so that it can be read when all others are lost. Chunks are not
/// compressed: their messages are. Not thread-safe.
class McapWriter {
 public:
  McapWriter(ByteSink sink, std::vector<McapSchema> schemas, std::vector<McapChannel> channels);

  /// Magic and header: once, before all else.
  [[nodiscard]] Result<void> begin();

  /// Into the chunk that is being filled; nothing is written.
  void add(const McapMessage& message);

  /// Bytes and messages that a flush would write.
  [[nodiscard]] std::size_t waiting_bytes() const { return messages_ == 0 ? 0 : chunk_.size(); }
  [[nodiscard]] std::uint64_t waiting_messages() const { return messages_; }

  /// The chunk in one call of the sink. When that fails the chunk is lost, what was written before is whole, and the
  /// writer can go on.
  [[nodiscard]] Result<void> flush();

  /// The last chunk, the summary and the end. After this the object is spent.
  [[nodiscard]] Result<void> finish();

 private:
  struct ChunkPlace {
    std::uint64_t begin_ns = 0, end_ns = 0;  // of log times
    std::uint64_t offset = 0, length = 0, records = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_length = 0;
  };
  struct IndexEntry {
    std::uint64_t log_ns, offset;
  };

  void begin_chunk();
  void close_chunk(ChunkPlace& place);
  void append_message_indexes(ChunkPlace& place);
  void append_chunk_index(const ChunkPlace& place, std::vector<std::byte>& bytes) const;
  void append_statistics(std::vector<std::byte>& bytes) const;
  [[nodiscard]] std::vector<std::byte> summary() const;
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);

  ByteSink sink_;
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  std::uint64_t offset_ = 0;      // of the next byte in the file
  std::vector<std::byte> chunk_;  // the record that is being filled, from its opcode on
  std::uint64_t messages_ = 0;    // in chunk_
  std::uint64_t begin_ns_ = 0, end_ns_ = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> index_;  // of chunk_
  std::vector<ChunkPlace> places_;
  std::map<std::uint16_t, std::uint64_t> counts_;  // messages written, by channel
};

}  // namespace scanknit
