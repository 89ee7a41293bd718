// The index at the end of an MCAP file, and the message indexes behind its chunks. Private to the reader.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "acquire/mcap/random_access.h"

namespace scanknit {

/// What the summary says of a chunk. Nothing of it has been compared with the file.
struct McapChunkPlace {
  std::uint64_t begin = 0, length = 0;  ///< of the whole record
  std::uint64_t index_length = 0;       ///< of the message indexes, which follow the record
  std::uint64_t unpacked = 0;
  std::vector<std::pair<std::uint16_t, std::uint64_t>> indexes;  ///< channels, and where their message index is
};

struct McapSummary {
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<McapChunkPlace> chunks;               ///< in the order of the file
  std::map<std::uint16_t, std::uint64_t> messages;  ///< their count, by channel

  /// The chunk whose record begins at `begin`; null: there is none.
  [[nodiscard]] const McapChunkPlace* find_chunk(std::uint64_t begin) const;
};

/// Nothing: the file has no end, no count of its messages, a damaged summary or one of more than 64 MiB.
[[nodiscard]] std::optional<McapSummary> read_mcap_summary(const RandomAccess& file);

struct McapIndexEntry {
  std::uint16_t channel = 0;
  std::uint64_t log_ns = 0;
  std::uint64_t offset = 0;  ///< of the message's record in the unpacked chunk
};

/// The messages of a chunk, in their order in it. Nothing: an index is missing, damaged, of another channel or at
/// another place than the summary says, or tells of messages that overlap or do not fit into the chunk.
[[nodiscard]] std::optional<std::vector<McapIndexEntry>> read_message_indexes(const RandomAccess& file,
                                                                              const McapChunkPlace& chunk);

}  // namespace scanknit
