// MCAP: a container of time-stamped messages, https://mcap.dev/spec (major version 0). The parts that writer and reader
// share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/files/byte_reader.h"

namespace scanknit {

inline constexpr std::array<std::byte, 8> kMcapMagic = {std::byte{0x89}, std::byte{'M'}, std::byte{'C'},
                                                        std::byte{'A'},  std::byte{'P'}, std::byte{'0'},
                                                        std::byte{'\r'}, std::byte{'\n'}};

enum class McapOp : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

inline constexpr std::size_t kMcapRecordHeader = 1 + 8;           // opcode, length of what follows
inline constexpr std::size_t kMcapMessageHeader = 2 + 4 + 8 + 8;  // channel, sequence, log time, publish time

/// The meaning of a channel's messages. `id` > 0.
struct McapSchema {
  std::uint16_t id = 0;
  std::string name;
  std::string encoding;  ///< "jsonschema"
  std::string text;
  friend bool operator==(const McapSchema&, const McapSchema&) = default;
};

struct McapChannel {
  std::uint16_t id = 0;
  std::uint16_t schema_id = 0;  ///< 0: none
  std::string topic;
  std::string message_encoding;
  std::map<std::string, std::string> metadata = {};  ///< written; not parsed
  friend bool operator==(const McapChannel&, const McapChannel&) = default;
};

/// Appends the whole record.
void append_schema(const McapSchema& schema, std::vector<std::byte>& bytes);
void append_channel(const McapChannel& channel, std::vector<std::byte>& bytes);

/// Parses the content of a record. Nothing: it is truncated, or a schema with the id 0.
[[nodiscard]] std::optional<McapSchema> parse_schema(std::span<const std::byte> content);
[[nodiscard]] std::optional<McapChannel> parse_channel(std::span<const std::byte> content);

/// A text after its length in 32 bits; nothing: it is truncated.
[[nodiscard]] std::optional<std::string> take_mcap_text(ByteReader& reader);

/// A record whose length is set when its content is complete.
class McapRecord {
 public:
  /// Begins a record at the end of `bytes`, which outlives this.
  McapRecord(McapOp op, std::vector<std::byte>& bytes);
  /// Sets the length. `bytes` end with the record's content.
  void close();

 private:
  std::vector<std::byte>& bytes_;
  std::size_t content_at_;
};

}  // namespace scanknit
