// One file of a bag of ROS 2: MCAP or SQLite, as it is or packed by zstd as a whole ("compression_mode: FILE").
#include <system_error>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/sqlite_file.h"
#include "acquire/mcap/zstd_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

bool is_plain_bag(const RandomAccess& file) {
  return mcap_profile(file) == "ros2" || is_sqlite(file);
}

/// Messages with one more fault.
class FaultyMessages final : public BagMessages {
 public:
  FaultyMessages(std::unique_ptr<BagMessages> messages, std::string fault)
      : messages_(std::move(messages)), fault_(std::move(fault)) {}

  [[nodiscard]] RosEncoding encoding() const override { return messages_->encoding(); }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return messages_->topics(); }
  [[nodiscard]] std::size_t size() const override { return messages_->size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override { return messages_->entry(message); }
  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    return messages_->read(message);
  }
  [[nodiscard]] Result<std::span<const std::byte>> read_alone(std::size_t message) override {
    return messages_->read_alone(message);
  }
  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    return messages_->peek(message, to);
  }
  [[nodiscard]] std::uint64_t indexed_bytes() const override { return messages_->indexed_bytes(); }
  [[nodiscard]] Result<bool> drop_wrong_index() override { return messages_->drop_wrong_index(); }
  [[nodiscard]] std::vector<std::string> faults() const override {
    auto faults = messages_->faults();
    faults.push_back(fault_);
    return faults;
  }

 private:
  std::unique_ptr<BagMessages> messages_;
  std::string fault_;
};

Result<std::unique_ptr<BagMessages>> open_plain(std::unique_ptr<RandomAccess> file, const Limits& limits) {
  if (is_sqlite(*file)) return open_db3_messages(std::move(file), limits);
  auto reader = McapReader::open(std::move(file), limits, McapIndexUse::kPacked);
  if (!reader) return reader.error();
  return messages_of_mcap(*std::move(reader), limits);
}

/// SQLite keeps what came last beside a database until it is closed.
std::optional<std::string> what_lies_beside(const fs::path& path) {
  for (const char* end : {"-wal", "-journal"}) {
    std::error_code code;
    const fs::path beside = path.string() + end;
    const auto size = fs::file_size(beside, code);
    if (code || size == 0) continue;
    return "the recorder has not closed the bag: messages in " + beside.string() + " are not read. `sqlite3 " +
           path.string() + " vacuum` takes them in";
  }
  return std::nullopt;
}

}  // namespace

bool is_bag_file(const RandomAccess& file) {
  constexpr std::size_t kFront = 1024;
  if (is_plain_bag(file)) return true;
  const auto front = zstd_front(file, kFront);
  return is_plain_bag(MemoryAccess(front));
}

Result<std::unique_ptr<BagMessages>> open_bag_file(std::unique_ptr<RandomAccess> file, const fs::path& path,
                                                   const Limits& limits) {
  constexpr std::size_t kSome = 4;
  std::optional<std::string> fault = what_lies_beside(path);
  if (!zstd_front(*file, kSome).empty()) {
    auto unpacked = unpack_zstd_file(*file);
    if (!unpacked) return unpacked.error();
    if (!unpacked->is_whole) fault = "the bag is torn: what zstd packed ends early. What is whole in it is read";
    file = std::move(unpacked->file);
  }
  auto messages = open_plain(std::move(file), limits);
  if (!messages || !fault) return messages;
  return std::unique_ptr<BagMessages>(std::make_unique<FaultyMessages>(*std::move(messages), *std::move(fault)));
}

}  // namespace scanknit
