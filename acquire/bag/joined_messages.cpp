// The parts of a bag as one.
#include <algorithm>
#include <map>
#include <utility>

#include "acquire/bag/bag_messages.h"

namespace scanknit {
namespace {

struct JoinedPart {
  std::unique_ptr<BagMessages> messages;
  std::size_t begin = 0;            // its first message's number
  std::vector<std::size_t> topics;  // numbers of its topics among all
};

class JoinedMessages final : public BagMessages {
 public:
  void add(std::unique_ptr<BagMessages> messages) {
    parts_.push_back({std::move(messages), 0, {}});
    number(parts_.back());
  }

  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return topics_; }
  [[nodiscard]] std::size_t size() const override { return size_; }
  [[nodiscard]] BagEntry entry(std::size_t message) const override {
    const JoinedPart& part = part_of(message);
    BagEntry entry = part.messages->entry(message - part.begin);
    entry.topic = part.topics[entry.topic];
    return entry;
  }
  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    const JoinedPart& part = part_of(message);
    return part.messages->read(message - part.begin);
  }
  [[nodiscard]] Result<std::span<const std::byte>> read_alone(std::size_t message) override {
    const JoinedPart& part = part_of(message);
    return part.messages->read_alone(message - part.begin);
  }
  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    const JoinedPart& part = part_of(message);
    return part.messages->peek(message - part.begin, to);
  }
  [[nodiscard]] std::vector<std::string> faults() const override {
    std::vector<std::string> faults;
    for (const JoinedPart& part : parts_) {
      const auto more = part.messages->faults();
      faults.insert(faults.end(), more.begin(), more.end());
    }
    return faults;
  }

  [[nodiscard]] std::uint64_t indexed_bytes() const override {
    std::uint64_t bytes = 0;
    for (const JoinedPart& part : parts_) bytes += part.messages->indexed_bytes();
    return bytes;
  }
  [[nodiscard]] Result<bool> drop_wrong_index() override {
    bool has_dropped = false;
    for (const JoinedPart& part : parts_) {
      const auto dropped = part.messages->drop_wrong_index();
      if (!dropped) return dropped;
      has_dropped |= *dropped;
    }
    if (!has_dropped) return false;
    topics_.clear();
    numbers_.clear();
    size_ = 0;
    for (JoinedPart& part : parts_) number(part);
    return true;
  }

 private:
  /// Puts the part's topics and messages behind those of the parts before it.
  void number(JoinedPart& part) {
    part.begin = size_;
    part.topics.clear();
    for (const BagTopic& topic : part.messages->topics()) {
      const auto [number, is_new] = numbers_.try_emplace({topic.name, topic.type}, topics_.size());
      if (is_new) topics_.push_back(topic);
      part.topics.push_back(number->second);
    }
    size_ += part.messages->size();
  }

  [[nodiscard]] const JoinedPart& part_of(std::size_t message) const {
    const auto after = std::upper_bound(parts_.begin(), parts_.end(), message,
                                        [](std::size_t number, const JoinedPart& part) { return number < part.begin; });
    return *std::prev(after);
  }

  std::vector<JoinedPart> parts_;
  std::vector<BagTopic> topics_;
  std::map<std::pair<std::string, std::string>, std::size_t> numbers_;  // of topics, by name and type
  std::size_t size_ = 0;
};

}  // namespace

Result<std::unique_ptr<BagMessages>> join_messages(std::vector<std::unique_ptr<BagMessages>> parts,
                                                   const Limits& limits) {
  auto joined = std::make_unique<JoinedMessages>();
  for (auto& part : parts) joined->add(std::move(part));
  if (joined->size() > limits.max_frames) {
    return Error{ErrorCode::kInput, "more messages than " + std::to_string(limits.max_frames)};
  }
  return std::unique_ptr<BagMessages>(std::move(joined));
}

}  // namespace scanknit
