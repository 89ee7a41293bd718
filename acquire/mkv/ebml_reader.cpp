#include "acquire/mkv/ebml_reader.h"

#include <algorithm>
#include <array>
#include <bit>

namespace scanknit {
namespace {

constexpr std::size_t kMostIdBytes = 4, kMostSizeBytes = 8;
constexpr std::uint64_t kMostEbmlTextBytes = 4096;

}  // namespace

std::optional<EbmlNumber> read_ebml_number(std::span<const std::byte> bytes) {
  if (bytes.empty() || bytes[0] == std::byte{0}) return std::nullopt;
  const auto first = std::to_integer<std::uint8_t>(bytes[0]);
  EbmlNumber number;
  number.length = static_cast<std::size_t>(std::countl_zero(first)) + 1;
  if (number.length > bytes.size()) return std::nullopt;
  number.value = first & (0xFFu >> number.length);
  for (std::size_t i = 1; i < number.length; ++i) {
    number.value = number.value << 8 | std::to_integer<std::uint64_t>(bytes[i]);
  }
  number.is_unknown = number.value == (std::uint64_t{1} << (7 * number.length)) - 1;
  return number;
}

std::optional<EbmlElement> EbmlWalk::next() {
  if (at_ >= end_) return std::nullopt;
  is_damaged_ = true;  // unless an element is found
  if (steps_ == 0) return std::nullopt;
  --steps_;
  std::array<std::byte, kMostIdBytes + kMostSizeBytes> raw{};
  const std::span head =
      std::span(raw).first(static_cast<std::size_t>(std::min<std::uint64_t>(raw.size(), end_ - at_)));
  if (!file_.read(at_, head)) return std::nullopt;
  const auto id = read_ebml_number(head);
  if (!id || id->length > kMostIdBytes) return std::nullopt;
  const auto size = read_ebml_number(head.subspan(id->length));
  if (!size) return std::nullopt;
  EbmlElement element;
  element.id = static_cast<std::uint32_t>(id->value | std::uint64_t{1} << (7 * id->length));
  element.start = at_;
  element.content = at_ + id->length + size->length;
  element.is_open = size->is_unknown;
  element.is_cut_off = !size->is_unknown && size->value > end_ - element.content;
  element.end = size->is_unknown || element.is_cut_off ? end_ : element.content + size->value;
  at_ = element.end;
  is_damaged_ = element.is_cut_off;
  return element;
}

std::optional<std::uint64_t> ebml_unsigned(const RandomAccess& file, const EbmlElement& element) {
  const auto bytes = ebml_bytes(file, element, sizeof(std::uint64_t));
  if (!bytes) return std::nullopt;
  std::uint64_t value = 0;
  for (const std::byte byte : *bytes) value = value << 8 | std::to_integer<std::uint64_t>(byte);
  return value;
}

std::optional<std::string> ebml_text(const RandomAccess& file, const EbmlElement& element) {
  const auto bytes = ebml_bytes(file, element, kMostEbmlTextBytes);
  if (!bytes) return std::nullopt;
  std::string text;
  for (const std::byte byte : *bytes) {
    if (byte == std::byte{0}) break;  // a text may be padded with zeros
    text += std::to_integer<char>(byte);
  }
  return text;
}

std::optional<std::vector<std::byte>> ebml_bytes(const RandomAccess& file, const EbmlElement& element,
                                                 std::uint64_t most_bytes) {
  if (element.is_open || element.is_cut_off || element.size() > most_bytes) return std::nullopt;
  std::vector<std::byte> bytes(static_cast<std::size_t>(element.size()));
  if (!file.read(element.content, bytes)) return std::nullopt;
  return bytes;
}

}  // namespace scanknit
