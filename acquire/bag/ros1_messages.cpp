// Bags of ROS 1 (wiki.ros.org/Bags).
#include <algorithm>
#include <map>
#include <utility>

#include "acquire/bag/bag_messages.h"

namespace scanknit {
namespace {

/// tf's messages had a name of their own before tf2.
std::string type_of_ros1(const std::string& type) {
  return type == "tf/tfMessage" ? "tf2_msgs/TFMessage" : type;
}

class Ros1Messages final : public BagMessages {
 public:
  explicit Ros1Messages(RosBag bag) : bag_(std::move(bag)) {
    std::map<std::pair<std::string, std::string>, std::size_t> known;  // each publisher has a connection of its own
    for (const BagConnection& connection : bag_.connections()) {
      const BagTopic topic{connection.topic, type_of_ros1(connection.type)};
      const auto [number, is_new] = known.try_emplace({topic.name, topic.type}, topics_.size());
      if (is_new) topics_.push_back(topic);
      numbers_[connection.id] = number->second;
    }
    const auto& messages = bag_.messages();
    for (std::size_t i = 0; i < messages.size(); ++i) {
      if (numbers_.contains(messages[i].connection)) kept_.push_back(static_cast<std::uint32_t>(i));
    }
  }

  [[nodiscard]] RosEncoding encoding() const override { return RosEncoding::kRos1; }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::size_t size() const override { return kept_.size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override {
    const BagMessage& place = bag_.messages()[kept_[message]];
    return {numbers_.at(place.connection), place.time_ns};
  }
  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    return bag_.read(bag_.messages()[kept_[message]]);
  }
  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    return bag_.peek(bag_.messages()[kept_[message]], to);
  }
  [[nodiscard]] std::vector<std::string> faults() const override {
    if (!bag_.fault()) return {};
    return {"the bag is torn: " + *bag_.fault() + ". What is whole in it is read"};
  }

 private:
  RosBag bag_;
  std::vector<BagTopic> topics_;
  std::map<std::uint32_t, std::size_t> numbers_;  // of topics, by connection
  std::vector<std::uint32_t> kept_;               // messages; there are fewer than Limits::max_frames
};

}  // namespace

std::unique_ptr<BagMessages> messages_of_ros1(RosBag bag) {
  return std::make_unique<Ros1Messages>(std::move(bag));
}

}  // namespace scanknit
