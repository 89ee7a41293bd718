// McapWriter: writes messages in self-contained chunks, each in one piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "core/result.h"

namespace scanknit {

/// Appends all bytes or none.
using ByteSink = std::function<Result<void>(std::span<const std::byte>)>;

struct McapMessage {
  std::uint16_t channel = 0;  ///< one of the writer's
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;
  std::uint64_t publish_ns = 0;
  std::span<const std::byte> data;
};

/// Every chunk repeats the schemas and channels, so that it can be read if all others are lost. Messages are
/// compressed, chunks are not. Not thread-safe.
class McapWriter {
 public:
  /// `profile`: what the file's header says of its channels.
  McapWriter(ByteSink sink, std::vector<McapSchema> schemas, std::vector<McapChannel> channels,
             std::string profile = "x-scanknit");

  /// Writes magic and header. To be called once, first.
  [[nodiscard]] Result<void> begin();

  /// Adds the message to the current chunk; writes nothing.
  void add(const McapMessage& message);

  /// Bytes and messages that a flush would write.
  [[nodiscard]] std::size_t waiting_bytes() const { return messages_ == 0 ? 0 : chunk_.size(); }
  [[nodiscard]] std::uint64_t waiting_messages() const { return messages_; }

  /// Writes the chunk with one call of the sink. If that fails, the chunk is lost; everything written before is intact,
  /// and the writer can continue.
  [[nodiscard]] Result<void> flush();

  /// Writes the last chunk, the summary and the end. The object must not be used after this.
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
  std::string profile_;
  std::uint64_t offset_ = 0;      // of the next byte in the file
  std::vector<std::byte> chunk_;  // the current record, from its opcode on
  std::uint64_t messages_ = 0;    // in chunk_
  std::uint64_t begin_ns_ = 0, end_ns_ = 0;
  std::map<std::uint16_t, std::vector<IndexEntry>> index_;  // of chunk_
  std::vector<ChunkPlace> places_;
  std::map<std::uint16_t, std::uint64_t> counts_;  // messages written, by channel
};

}  // namespace scanknit
