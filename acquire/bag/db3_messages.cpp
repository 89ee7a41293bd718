// Bags of ROS 2 in databases of SQLite (rosbag2_storage_sqlite3): the tables `topics` and `messages`.
#include <algorithm>
#include <map>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/sqlite_file.h"
#include "acquire/bag/zstd_messages.h"

namespace scanknit {
namespace {

constexpr std::size_t kMostTopics = 1000;

struct Db3Place {
  SqlitePlace row;
  std::uint64_t offset = 0, length = 0;  // of the message in the row
  std::int64_t log_ns = 0;
  std::size_t topic = 0;
};

Error no_table(const char* table) {
  return {ErrorCode::kInput, std::string("a database of SQLite, but no bag of ROS 2: expected a table '") + table +
                                 "' as rosbag2 writes it"};
}

class Db3Messages final : public BagMessages {
 public:
  Db3Messages(SqliteFile database, const Limits& limits) : database_(std::move(database)), limits_(limits) {}

  [[nodiscard]] Result<void> index(std::uint64_t file_size) {
    if (const auto found = index_topics(); !found) return found.error();
    return index_messages(file_size);
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::size_t size() const override { return places_.size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override {
    return {places_[message].topic, places_[message].log_ns};
  }

  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    const Db3Place& place = places_[message];
    if (place.length > limits_.max_image_bytes) {
      return Error{ErrorCode::kInput, "a message has more bytes than " + std::to_string(limits_.max_image_bytes)};
    }
    bytes_.resize(static_cast<std::size_t>(place.length));
    if (!database_.read(place.row, place.offset, bytes_)) {
      return Error{ErrorCode::kInput, "a message is cut off: the bag is torn"};
    }
    return std::span<const std::byte>(bytes_);
  }

  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    const Db3Place& place = places_[message];
    return to.size() <= place.length && database_.read(place.row, place.offset, to);
  }

  [[nodiscard]] std::vector<std::string> faults() const override {
    if (!database_.fault()) return {};
    return {"the bag is torn: " + *database_.fault() + ". What is whole in it is read"};
  }

 private:
  [[nodiscard]] Result<void> index_topics() {
    const auto table = database_.find_table("topics");
    const auto name = table ? table->column("name") : std::nullopt;
    const auto type = table ? table->column("type") : std::nullopt;
    const auto format = table ? table->column("serialization_format") : std::nullopt;
    if (!name || !type || !format) return no_table("topics");
    database_.visit_rows(table->root, [&](const SqliteRow& row) {
      BagTopic topic{database_.text(row, *name).value_or(""), without_msg(database_.text(row, *type).value_or(""))};
      if (database_.text(row, *format) != "cdr") topic.type.clear();
      if (numbers_.try_emplace(row.id, topics_.size()).second) topics_.push_back(std::move(topic));
      return topics_.size() < kMostTopics;
    });
    return {};
  }

  [[nodiscard]] Result<void> index_messages(std::uint64_t file_size) {
    const auto table = database_.find_table("messages");
    const auto topic = table ? table->column("topic_id") : std::nullopt;
    const auto time = table ? table->column("timestamp") : std::nullopt;
    const auto data = table ? table->column("data") : std::nullopt;
    if (!topic || !time || !data) return no_table("messages");
    std::uint64_t bytes_left = file_size;  // rows that share their bytes are nobody's
    database_.visit_rows(table->root, [&](const SqliteRow& row) {
      if (row.place.size > bytes_left || places_.size() > limits_.max_frames) return false;
      bytes_left -= row.place.size;
      if (std::max({*topic, *time, *data}) >= row.columns.size()) return true;
      const auto number = numbers_.find(row.columns[*topic].integer);
      const SqliteColumn& message = row.columns[*data];
      if (number == numbers_.end() || message.kind != SqliteColumn::Kind::kBlob) return true;
      places_.push_back({row.place, message.offset, message.length, row.columns[*time].integer, number->second});
      return true;
    });
    if (places_.size() <= limits_.max_frames) return {};
    return Error{ErrorCode::kInput, "more messages than " + std::to_string(limits_.max_frames)};
  }

  SqliteFile database_;
  Limits limits_;
  std::vector<BagTopic> topics_;
  std::map<std::int64_t, std::size_t> numbers_;  // of topics, by their id
  std::vector<Db3Place> places_;
  std::vector<std::byte> bytes_;
};

}  // namespace

Result<std::unique_ptr<BagMessages>> open_db3_messages(std::unique_ptr<RandomAccess> file, const Limits& limits) {
  const std::uint64_t size = file->size();
  auto database = SqliteFile::open(std::move(file));
  if (!database) return database.error();
  auto messages = std::make_unique<Db3Messages>(*std::move(database), limits);
  if (const auto indexed = messages->index(size); !indexed) return indexed.error();
  return unpack_messages(std::move(messages), limits);
}

}  // namespace scanknit
