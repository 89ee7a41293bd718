#include "acquire/bag/zstd_messages.h"

#include <algorithm>
#include <utility>

#include "acquire/mcap/zstd_bytes.h"

namespace scanknit {
namespace {

class ZstdMessages final : public BagMessages {
 public:
  ZstdMessages(std::unique_ptr<BagMessages> packed, const Limits& limits)
      : packed_(std::move(packed)), limits_(limits) {}

  [[nodiscard]] RosEncoding encoding() const override { return packed_->encoding(); }
  [[nodiscard]] const std::vector<BagTopic>& topics() const override { return packed_->topics(); }
  [[nodiscard]] std::size_t size() const override { return packed_->size(); }
  [[nodiscard]] BagEntry entry(std::size_t message) const override { return packed_->entry(message); }
  [[nodiscard]] std::vector<std::string> faults() const override { return packed_->faults(); }

  [[nodiscard]] std::uint64_t indexed_bytes() const override { return packed_->indexed_bytes(); }
  [[nodiscard]] Result<bool> drop_wrong_index() override { return packed_->drop_wrong_index(); }

  [[nodiscard]] Result<std::span<const std::byte>> read(std::size_t message) override {
    return unpacked(packed_->read(message));
  }
  [[nodiscard]] Result<std::span<const std::byte>> read_alone(std::size_t message) override {
    return unpacked(packed_->read_alone(message));
  }

  [[nodiscard]] bool peek(std::size_t message, std::span<std::byte> to) override {
    if (!packed_->peek(message, to)) return false;
    if (!is_zstd(to)) return true;
    const auto bytes = read(message);
    if (!bytes || bytes->size() < to.size()) return false;
    std::copy_n(bytes->begin(), to.size(), to.begin());
    return true;
  }

 private:
  [[nodiscard]] Result<std::span<const std::byte>> unpacked(const Result<std::span<const std::byte>>& bytes) {
    if (!bytes || !is_zstd(*bytes)) return bytes;
    const auto size = zstd_content_size(*bytes);
    if (size > limits_.max_image_bytes) {
      return Error{ErrorCode::kInput,
                   "a packed message has more bytes than " + std::to_string(limits_.max_image_bytes)};
    }
    auto plain = zstd_unpack(*bytes, static_cast<std::size_t>(size.value_or(0)));
    if (!plain) return plain.error();
    bytes_ = *std::move(plain);
    return std::span<const std::byte>(bytes_);
  }

  std::unique_ptr<BagMessages> packed_;
  Limits limits_;
  std::vector<std::byte> bytes_;
};

}  // namespace

std::unique_ptr<BagMessages> unpack_messages(std::unique_ptr<BagMessages> packed, const Limits& limits) {
  return std::make_unique<ZstdMessages>(std::move(packed), limits);
}

}  // namespace scanknit
