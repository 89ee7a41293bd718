// McapReader: finds every message of an MCAP file, whether or not its index is there, and reads them a chunk at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/mcap_format.h"
#include "acquire/mcap/mcap_summary.h"
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

/// Whether the messages of compressed chunks are found by the file's index, where it has one.
enum class McapIndexUse {
  kNone,   ///< every compressed chunk is unpacked once when the file is opened
  kPacked  ///< where summary and message indexes agree; see McapReader::drop_wrong_index()
};

/// Not thread-safe. The file may be truncated or damaged: finds all complete chunks before and after the damage.
/// Chunks: uncompressed, zstd or lz4.
class McapReader {
 public:
  /// Goes from record to record without reading any message. Errors (kInput, without `where`): not an MCAP file, more
  /// messages than `limits.max_frames`.
  [[nodiscard]] static Result<McapReader> open(std::unique_ptr<RandomAccess> file, const Limits& limits,
                                               McapIndexUse use = McapIndexUse::kNone);

  [[nodiscard]] const std::vector<McapSchema>& schemas() const { return schemas_; }
  [[nodiscard]] const std::vector<McapChannel>& channels() const { return channels_; }
  [[nodiscard]] const McapChannel* find_channel(std::string_view topic) const;

  /// In the order of the file. Of those that were found by the index only channel and log time are known, and where
  /// they are.
  [[nodiscard]] const std::deque<McapMessagePlace>& messages() const { return messages_; }

  /// A message's data; valid until the next call. Errors (kInput, without `where`): its chunk is larger than the
  /// limits, unreadable or damaged.
  [[nodiscard]] Result<std::span<const std::byte>> read(const McapMessagePlace& message);

  /// read(), but a small message of a large chunk that is not compressed is read alone, without the chunk's checksum.
  [[nodiscard]] Result<std::span<const std::byte>> read_alone(const McapMessagePlace& message);

  /// The first bytes of a message's data, `to` of them, without the chunk's checksum; false: there are not so many.
  /// Reads no more than these where the chunk is not compressed.
  [[nodiscard]] bool peek(const McapMessagePlace& message, std::span<std::byte> to);

  /// Bytes of compressed chunks that were not unpacked, because the index tells what is in them.
  [[nodiscard]] std::uint64_t indexed_bytes() const { return indexed_bytes_; }

  /// Every chunk that is unpacked is compared with the index. Where it was wrong, forgets it, goes over the whole file
  /// as if there were none, and returns true: messages() are others then. Errors: those of open().
  [[nodiscard]] Result<bool> drop_wrong_index();

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
    bool is_indexed = false;                      // its messages were found by the index
    std::size_t first_message = 0, messages = 0;  // of an indexed chunk, in messages_
  };
  struct LoadedChunk {
    std::uint32_t index = 0;
    std::uint64_t used = 0;  // when it was last used
    std::optional<Result<std::vector<std::byte>>> records;
  };

  McapReader(std::unique_ptr<RandomAccess> file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}

  [[nodiscard]] static std::optional<Record> record_at(const RandomAccess& bytes, std::uint64_t at, std::uint64_t end);
  [[nodiscard]] Result<void> walk_file();
  [[nodiscard]] Result<void> walk_with_index();
  [[nodiscard]] Result<void> walk_without_index();
  /// False: the index does not tell what is in it.
  [[nodiscard]] bool note_indexed(const Record& record, const Chunk& chunk);
  [[nodiscard]] bool is_count_as_stated() const;
  [[nodiscard]] bool is_as_indexed(const Chunk& chunk, std::span<const std::byte> records) const;
  [[nodiscard]] bool is_private_record(const Record& record) const;
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
  std::deque<Chunk> chunks_;  // these two are long: they grow without a copy
  std::deque<McapMessagePlace> messages_;
  std::optional<std::string> fault_;
  std::array<LoadedChunk, 2> cache_;  // depth and its colour may be in two successive chunks
  std::uint64_t reads_ = 0;
  bool has_chunks_ = false;
  std::optional<McapSummary> summary_;  // only where its index is used
  std::uint64_t indexed_bytes_ = 0;
  bool is_index_wrong_ = false;
  std::vector<std::byte> alone_;  // of read_alone()
  int trials_ = 0;                // chunks unpacked in the search for the next intact one
};

/// True when the file begins as an MCAP file does.
[[nodiscard]] bool is_mcap(const RandomAccess& file);

/// The profile that the file's header states ("ros2"); empty: none, or no MCAP file.
[[nodiscard]] std::string mcap_profile(const RandomAccess& file);

}  // namespace scanknit
