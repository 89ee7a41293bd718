// McapReader: finds every message of an MCAP file without trusting its index, and reads them a chunk at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// The place of a message, and its header. The chunk's CRC has not been checked yet.
struct McapMessagePlace {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;
  std::uint64_t publish_ns = 0;
  std::uint32_t chunk = 0;   ///< index of the chunk
  std::uint64_t offset = 0;  ///< of the data in the chunk's records
  std::uint64_t length = 0;  ///< of the data
};

/// Not thread-safe. The file may be truncated or damaged: finds all complete chunks before and after the damage. Does
/// not use the summary or the message indexes. Chunks: uncompressed or zstd.
class McapReader {
 public:
  /// Goes from record to record without reading any message. Errors (kInput, without `where`): not an MCAP file, more
  /// messages than `limits.max_frames`.
  [[nodiscard]] static Result<McapReader> open(std::unique_ptr<RandomAccess> file, const Limits& limits);

  [[nodiscard]] const std::vector<McapSchema>& schemas() const { return schemas_; }
  [[nodiscard]] const std::vector<McapChannel>& channels() const { return channels_; }
  [[nodiscard]] const McapChannel* find_channel(std::string_view topic) const;

  /// In the order of the file.
  [[nodiscard]] const std::vector<McapMessagePlace>& messages() const { return messages_; }

  /// A message's data; valid until the next call. Errors (kInput, without `where`): its chunk is larger than the
  /// limits, unreadable or damaged.
  [[nodiscard]] Result<std::span<const std::byte>> read(const McapMessagePlace& message);

  /// The first bytes of a message's data, `to` of them, without the chunk's checksum; false: there are not so many.
  /// Reads no more than these where the chunk is not compressed.
  [[nodiscard]] bool peek(const McapMessagePlace& message, std::span<std::byte> to);

  /// The fault of the file as a whole, as text: it ends early, or some of its chunks cannot be read. Nothing if the
  /// file is complete.
  [[nodiscard]] const std::optional<std::string>& fault() const { return fault_; }

 private:
  struct Record {
    McapOp op = McapOp::kHeader;
    std::uint64_t begin = 0, length = 0;  // of the content
    [[nodiscard]] std::uint64_t end() const { return begin + length; }
  };
  enum class Packing { kNone, kZstd, kLz4 };
  struct Chunk {
    std::uint64_t begin = 0, length = 0;  // of the records as stored
    std::uint64_t unpacked = 0;           // their size
    std::uint32_t crc = 0;                // 0: not known
    Packing packing = Packing::kNone;
  };
  struct LoadedChunk {
    std::uint32_t index = 0;
    std::uint64_t used = 0;  // when it was last used
    std::optional<Result<std::vector<std::byte>>> records;
  };

  McapReader(std::unique_ptr<RandomAccess> file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}

  [[nodiscard]] static std::optional<Record> record_at(const RandomAccess& bytes, std::uint64_t at, std::uint64_t end);
  [[nodiscard]] Result<void> walk_file();
  /// The beginning of the first intact chunk at `from` or later.
  [[nodiscard]] std::optional<std::uint64_t> find_chunk(std::uint64_t from);
  [[nodiscard]] bool is_whole_chunk(std::uint64_t at);
  /// False: damaged.
  [[nodiscard]] Result<bool> walk_chunk(const Record& record);
  /// A message of a file that has no chunks.
  [[nodiscard]] Result<bool> walk_message(const Record& record);
  [[nodiscard]] Result<void> check_count() const;
  [[nodiscard]] bool walk_records(const RandomAccess& bytes, std::uint64_t begin, std::uint64_t end);
  [[nodiscard]] bool note_message(const RandomAccess& bytes, const Record& record, std::uint64_t base);
  void note_definition(const RandomAccess& bytes, const Record& record);
  [[nodiscard]] std::optional<Chunk> parse_chunk(const Record& record) const;
  [[nodiscard]] Result<std::vector<std::byte>> load(const Chunk& chunk) const;
  [[nodiscard]] const Result<std::vector<std::byte>>& loaded(std::uint32_t index);
  void note_fault(std::string text);

  std::unique_ptr<RandomAccess> file_;
  Limits limits_;
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  std::vector<Chunk> chunks_;
  std::vector<McapMessagePlace> messages_;
  std::optional<std::string> fault_;
  std::array<LoadedChunk, 2> cache_;  // depth and its colour may be in two successive chunks
  std::uint64_t reads_ = 0;
  bool has_chunks_ = false;
  int trials_ = 0;  // chunks unpacked in the search for the next intact one
};

/// True when the file begins as an MCAP file does.
[[nodiscard]] bool is_mcap(const RandomAccess& file);

/// The profile that the file's header states ("ros2"); empty: none, or no MCAP file.
[[nodiscard]] std::string mcap_profile(const RandomAccess& file);

}  // namespace scanknit
