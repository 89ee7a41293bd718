// Bags of ROS 2 in MCAP files (rosbag2_storage_mcap).
#include <map>
#include <utility>

#include "acquire/bag/bag_messages.h"
#include "acquire/bag/zstd_messages.h"

namespace scanknit {
namespace {

class McapMessages final : public BagMessages {
 public:
  explicit McapMessages(McapReader reader) : reader_(std::move(reader)) {
    for (const McapChannel& channel : reader_.channels()) {
      numbers_[channel.id] = topics_.size();
      topics_.push_back({channel.topic, type_of(channel)});
    }
    // A channel that is not described is damaged, and its messages are nobody's.
    const auto& places = reader_.messages();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!numbers_.contains(places[i].channel)) continue;
      kept_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::size_t size() const override { return kept_.size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override {
    const McapMessagePlace& place = place_of(message);
    return {numbers_.at(place.channel), static_cast<std::int64_t>(place.log_ns)};
  }
  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    return reader_.read(place_of(message));
  }
  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    return reader_.peek(place_of(message), to);
  }
  [[nodiscard]] std::vector<std::string> faults() const override {
    if (!reader_.fault()) return {};
    return {"the bag is torn: " + *reader_.fault() + ". What is whole in it is read"};
  }

 private:
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
