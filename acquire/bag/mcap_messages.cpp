// Bags of ROS 2 in MCAP files (rosbag2_storage_mcap).
#include <map>
#include <set>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/zstd_messages.h"

namespace scanknit {
namespace {

class McapMessages final : public BagMessages {
 public:
  explicit McapMessages(McapReader reader) : reader_(std::move(reader)) { number(); }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::size_t size() const override { return kept_.size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override {
    const McapMessagePlace& place = place_of(message);
    return {numbers_.at(place.channel), static_cast<std::int64_t>(place.log_ns)};
  }
  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    return reader_.read(place_of(message));
  }
  [[nodiscard]] Result<std::span<const std::byte>> read_alone(std::size_t message) override {
    return reader_.read_alone(place_of(message));
  }
  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    return reader_.peek(place_of(message), to);
  }
  [[nodiscard]] std::vector<std::string> faults() const override {
    if (!reader_.fault()) return {};
    return {"the bag is torn: " + *reader_.fault() + ". What is whole in it is read"};
  }

  [[nodiscard]] std::uint64_t indexed_bytes() const override { return reader_.indexed_bytes(); }
  [[nodiscard]] Result<bool> drop_wrong_index() override {
    const auto dropped = reader_.drop_wrong_index();
    if (dropped && *dropped) number();
    return dropped;
  }

 private:
  /// The topics that have messages, and these. A channel that is not described is damaged, and its messages are
  /// nobody's.
  void number() {
    topics_.clear();
    numbers_.clear();
    kept_.clear();
    const auto& places = reader_.messages();
    std::set<std::uint16_t> used;
    for (const McapMessagePlace& place : places) used.insert(place.channel);
    for (const McapChannel& channel : reader_.channels()) {
      if (!used.contains(channel.id)) continue;
      numbers_[channel.id] = topics_.size();
      topics_.push_back({channel.topic, type_of(channel)});
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (numbers_.contains(places[i].channel)) kept_.push_back(static_cast<std::uint32_t>(i));
    }
  }
  [[nodiscard]] std::string type_of(const McapChannel& channel) const {
    if (channel.message_encoding != "cdr") return {};
    for (const McapSchema& schema : reader_.schemas()) {
      if (schema.id == channel.schema_id) return without_msg(schema.name);
    }
    return {};
  }
  [[nodiscard]] const McapMessagePlace& place_of(std::size_t message) const {
    return reader_.messages()[kept_[message]];
  }

  McapReader reader_;
  std::vector<BagTopic> topics_;
  std::map<std::uint16_t, std::size_t> numbers_;  // of topics, by channel
  std::vector<std::uint32_t> kept_;               // places; there are fewer than Limits::max_frames
};

}  // namespace

std::unique_ptr<BagMessages> messages_of_mcap(McapReader reader, const Limits& limits) {
  return unpack_messages(std::make_unique<McapMessages>(std::move(reader)), limits);
}

}  // namespace scanknit
