// BagMessages: the messages of a bag of ROS, whatever files hold them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquire/bag/ros_bag.h"
#include "acquire/bag/ros_message.h"
#include "acquire/mcap/mcap_reader.h"
#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct BagTopic {
  std::string name;
  std::string type;  ///< "sensor_msgs/Image", without "msg"; empty: its messages are in an encoding that is not read
};

/// A message before it is read.
struct BagEntry {
  std::size_t topic = 0;    ///< in BagMessages::topics()
  std::int64_t log_ns = 0;  ///< when it was recorded
};

/// Not thread-safe. Messages are numbered from 0 in the order in which they are held; none is kept in memory.
class BagMessages {
 public:
  virtual ~BagMessages() = default;
  [[nodiscard]] virtual RosEncoding encoding() const { return RosEncoding::kCdr; }
  [[nodiscard]] virtual const std::vector<BagTopic>& topics() const = 0;
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual BagEntry entry(std::size_t message) const = 0;

  /// A message's bytes; valid until the next call. Errors (kInput, without `where`): damaged, beyond the limits.
  [[nodiscard]] virtual Result<std::span<const std::byte>> read(std::size_t message) = 0;

  /// read(), but of a large chunk that is not compressed no more than the message is read, and the chunk's checksum is
  /// not looked at. For messages that are small and in every chunk.
  [[nodiscard]] virtual Result<std::span<const std::byte>> read_alone(std::size_t message) { return read(message); }

  /// The first bytes of a message, `to` of them; false: there are not so many. Reads little else where it can.
  [[nodiscard]] virtual bool peek(std::size_t message, std::span<std::byte> to) = 0;

  /// What is wrong with the files as a whole, as sentences; empty: nothing.
  [[nodiscard]] virtual std::vector<std::string> faults() const = 0;

  /// Compressed bytes that were not unpacked, because an index tells what messages are in them; 0: there is none.
  [[nodiscard]] virtual std::uint64_t indexed_bytes() const { return 0; }

  /// To be called when messages have been read. Where the index turned out to be wrong, goes over the files as if there
  /// were none, and returns true: topics and messages have other numbers then. Errors (kInput, without `where`): those
  /// of opening.
  [[nodiscard]] virtual Result<bool> drop_wrong_index() { return false; }
};

// Each gives the messages of one file, those that are packed by zstd (rosbag2_compression) unpacked.

[[nodiscard]] std::unique_ptr<BagMessages> messages_of_mcap(McapReader reader, const Limits& limits);
[[nodiscard]] std::unique_ptr<BagMessages> messages_of_ros1(RosBag bag);

/// A file of rosbag2_storage_sqlite3. Errors (kInput, without `where`): no database of SQLite, no table that a bag has,
/// more messages than `limits.max_frames`.
[[nodiscard]] Result<std::unique_ptr<BagMessages>> open_db3_messages(std::unique_ptr<RandomAccess> file,
                                                                     const Limits& limits);

/// A file of ROS 2 of either kind, or one of these that zstd packed as a whole, by its first bytes.
[[nodiscard]] bool is_bag_file(const RandomAccess& file);

/// Errors (kInput, without `where`): those of its kind; no bag of ROS 2.
[[nodiscard]] Result<std::unique_ptr<BagMessages>> open_bag_file(std::unique_ptr<RandomAccess> file,
                                                                 const std::filesystem::path& path,
                                                                 const Limits& limits);

/// The parts of one bag, one after the other; topics of the same name are one. Errors (kInput, without `where`): more
/// messages than `limits.max_frames`.
[[nodiscard]] Result<std::unique_ptr<BagMessages>> join_messages(std::vector<std::unique_ptr<BagMessages>> parts,
                                                                 const Limits& limits);

struct OpenBag {
  std::unique_ptr<BagMessages> messages = nullptr;
  std::vector<std::string> warnings = {};  ///< of parts that are left out
};

struct Folder;  // acquire/replay/folder.h

/// A folder that fits_split_bag() (acquire/replay/layouts.h). Errors (kInput): no part can be read; those of
/// join_messages().
[[nodiscard]] Result<OpenBag> open_split_bag(const Folder& folder, const Limits& limits);

/// False where the bag says in its index, or in metadata.yaml beside it, that none of its topics is of `type`
/// ("sensor_msgs/PointCloud2"). Its messages are not gone over: true also where nothing says it. `path`: a file, or a
/// folder of parts.
[[nodiscard]] bool may_have_type(const std::filesystem::path& path, const std::string& type, const Limits& limits);

/// `type` as BagTopic has it: "sensor_msgs/msg/Image" is also written "sensor_msgs/Image".
[[nodiscard]] inline std::string without_msg(std::string type) {
  if (const auto middle = type.find("/msg/"); middle != std::string::npos) type.erase(middle, 4);
  return type;
}

}  // namespace scanknit
