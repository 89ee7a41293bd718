#include "acquire/layouts/oni_depth.h"

#include <optional>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

// A byte below kRuns holds two steps of -6 to 7, each plus 6; its lower half may be a sign instead.
constexpr unsigned kStepOffset = 6;
constexpr unsigned kRuns = 0xE0;      // 0xE0 + n: twice n values as the one before
constexpr unsigned kAllLong = 0xFF;   // a long step or a whole value follows
constexpr unsigned kHalfLong = 0x0F;  // the same, after a small step
constexpr unsigned kHalfNone = 0x0D;  // a picture with an even rest of values ends so
// A long step of -64 to 63 is one byte, plus 192; a whole value, below 2^15, two: the higher first.
constexpr unsigned kLongStep = 0x80;
constexpr unsigned kLongOffset = 192;

const Error kTorn{ErrorCode::kInput, "the depth picture's packed values end in the middle, or are too many"};
const Error kOutside{ErrorCode::kInput, "the depth picture has values that are not in its table"};

class Unpacker {
 public:
  Unpacker(std::span<const std::byte> packed, std::size_t pixels) : reader_(packed), pixels_(pixels) {}

  [[nodiscard]] bool read_table() {
    const auto count = reader_.little_endian<std::uint16_t>();
    const auto bytes = count ? reader_.take(std::size_t{2} * *count) : std::nullopt;
    if (!bytes) return false;
    ByteReader entries(*bytes);
    while (const auto entry = entries.little_endian<std::uint16_t>()) table_.push_back(*entry);
    has_table_ = true;
    return true;
  }

  [[nodiscard]] bool read_values() {
    const auto first = reader_.little_endian<std::uint16_t>();
    if (!first) return false;
    values_.reserve(pixels_);
    last_ = *first;
    bool is_good = put(1);
    while (is_good && reader_.remaining() > 0) is_good = read_group();
    return is_good && values_.size() == pixels_;
  }

  [[nodiscard]] bool is_outside_table() const { return is_outside_table_; }
  [[nodiscard]] std::vector<std::uint16_t> take_values() { return std::move(values_); }

 private:
  [[nodiscard]] bool read_group() {
    const unsigned byte = *reader_.little_endian<std::uint8_t>();
    if (byte == kAllLong) return read_long();
    if (byte >= kRuns) return put(2 * std::size_t{byte - kRuns});
    if (!step((byte >> 4) - kStepOffset)) return false;
    const unsigned half = byte & 0x0F;
    if (half == kHalfLong) return read_long();
    return half == kHalfNone || step(half - kStepOffset);
  }

  [[nodiscard]] bool read_long() {
    const auto high = reader_.little_endian<std::uint8_t>();
    if (!high) return false;
    if ((*high & kLongStep) != 0) return step(*high - kLongOffset);
    const auto low = reader_.little_endian<std::uint8_t>();
    if (!low) return false;
    last_ = static_cast<std::uint16_t>(*high << 8 | *low);
    return put(1);
  }

  // Steps lead downwards, modulo 2^16.
  [[nodiscard]] bool step(unsigned down) {
    last_ = static_cast<std::uint16_t>(last_ - down);
    return put(1);
  }

  [[nodiscard]] bool put(std::size_t count) {
    if (count > pixels_ - values_.size()) return false;
    is_outside_table_ = has_table_ && last_ >= table_.size();
    if (is_outside_table_) return false;
    values_.insert(values_.end(), count, has_table_ ? table_[last_] : last_);
    return true;
  }

  ByteReader reader_;
  std::size_t pixels_;
  bool has_table_ = false, is_outside_table_ = false;
  std::vector<std::uint16_t> table_, values_;
  std::uint16_t last_ = 0;
};

}  // namespace

Result<std::vector<std::uint16_t>> unpack_oni_depth(std::span<const std::byte> packed, bool has_table,
                                                    std::size_t pixels) {
  Unpacker unpacker(packed, pixels);
  if (has_table && !unpacker.read_table()) return kTorn;
  if (!unpacker.read_values()) return unpacker.is_outside_table() ? kOutside : kTorn;
  return unpacker.take_values();
}

}  // namespace scanknit
