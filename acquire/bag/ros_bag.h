// RosBag: the container of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0). Of its index only the end is looked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct BagConnection {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;  ///< "sensor_msgs/Image"
};

struct BagMessage {
  std::uint32_t connection = 0;
  std::int64_t time_ns = 0;  ///< when it was recorded
  std::uint32_t chunk = 0;
  std::size_t offset = 0, length = 0;  ///< of its data in the unpacked chunk
};

/// Not thread-safe. A bag that ends early gives what came whole before.
class RosBag {
 public:
  /// Unpacks every chunk that is compressed once, one at a time (bz2 and lz4; of others the records' heads are read).
  /// Errors (kInput, without `where`): not a bag, more messages than `limits.max_frames`.
  [[nodiscard]] static Result<RosBag> open(std::unique_ptr<RandomAccess> file, const Limits& limits);

  /// The connections that the index at the end of the file lists; nothing else is read. Nothing: there is no whole
  /// index.
  [[nodiscard]] static std::optional<std::vector<BagConnection>> indexed_connections(std::unique_ptr<RandomAccess> file,
                                                                                     const Limits& limits);

  [[nodiscard]] const std::vector<BagConnection>& connections() const { return connections_; }
  /// In the order of the file.
  [[nodiscard]] const std::vector<BagMessage>& messages() const { return messages_; }
  /// A message's data; valid until the next call. Errors (kInput, without `where`): its chunk cannot be read any more.
  [[nodiscard]] Result<std::span<const std::byte>> read(const BagMessage& message);
  /// The first bytes of a message's data, `to` of them; false: there are not so many. Reads no more than these where
  /// the chunk is not compressed.
  [[nodiscard]] bool peek(const BagMessage& message, std::span<std::byte> to);
  /// What is wrong with the file as a whole ("it is cut off at byte 77, ..."); nothing when it has its index.
  [[nodiscard]] const std::optional<std::string>& fault() const { return fault_; }

 private:
  struct Chunk {
    std::uint64_t begin = 0;
    std::size_t packed = 0, unpacked = 0;
    std::string compression;
  };
  struct LoadedChunk {
    std::uint32_t index = 0;
    std::uint64_t used = 0;
    std::optional<std::vector<std::byte>> bytes;
  };

  enum class RecordState { kWhole, kCut, kDamaged };

  RosBag(std::unique_ptr<RandomAccess> file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}
  [[nodiscard]] Result<void> walk();
  [[nodiscard]] RecordState walk_record(std::uint64_t& at);
  [[nodiscard]] std::string describe_end(RecordState state, std::uint64_t begin) const;
  [[nodiscard]] bool walk_chunk(const Chunk& chunk);
  [[nodiscard]] bool walk_records(const RandomAccess& bytes, std::uint64_t begin, std::uint64_t end);
  void note_connection(std::uint32_t id, std::string topic, std::span<const std::byte> description);
  [[nodiscard]] std::optional<std::vector<std::byte>> load(const Chunk& chunk) const;

  std::unique_ptr<RandomAccess> file_;
  Limits limits_;
  std::vector<BagConnection> connections_;
  std::vector<BagMessage> messages_;
  std::vector<Chunk> chunks_;
  std::optional<std::string> fault_;
  std::optional<bool> is_finished_;  ///< as the bag's header says; nothing: it has not come
  std::uint64_t promised_index_records_ = 0, index_records_ = 0;
  std::uint64_t index_begin_ = 0, promised_connections_ = 0;
  std::array<LoadedChunk, 2> cache_;
  std::vector<std::byte> alone_;  // a message of a chunk that is not compressed
  std::uint64_t reads_ = 0;
};

[[nodiscard]] bool is_ros_bag(const RandomAccess& file);

}  // namespace scanknit
