#include "extract/volume/dicom_structure.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kUndefinedLength = 0xffffffff;
constexpr std::uint32_t kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd;
constexpr int kMaxDepth = 32;

struct Element {
  std::uint32_t tag = 0;
  std::uint32_t length = 0;
  bool is_sequence = false;
};

std::string text_of(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    if (b != std::byte{0}) text += static_cast<char>(b);
  }
  return text;
}

class Walker {
 public:
  explicit Walker(std::span<const std::byte> bytes) : reader_(bytes) {}

  bool walk() {
    const auto head = reader_.take(132);
    if (!head || text_of(head->subspan(128)) != "DICM") return false;
    const auto element = next();  // the length of the rest of group 2
    if (!element || element->tag != 0x00020000 || element->length != 4) return false;
    const auto length = reader_.little_endian<std::uint32_t>();
    const auto meta = length ? reader_.take(*length) : std::nullopt;
    if (!meta || !choose_syntax(*meta)) return false;
    return walk_elements(0, 0) && has_pixels_;
  }

 private:
  bool choose_syntax(std::span<const std::byte> meta) {
    Walker walker(meta);
    std::string syntax;
    std::uint32_t last = 0x00020000;
    while (walker.reader_.remaining() > 0) {
      const auto element = walker.next();
      if (!element || element->tag <= std::exchange(last, element->tag)) return false;
      const auto value = walker.reader_.take(element->length);
      if (!value || element->tag >> 16 != 2) return false;
      if (element->tag == 0x00020010) syntax = text_of(*value);
    }
    is_explicit_ = syntax != "1.2.840.10008.1.2";
    is_big_ = syntax == "1.2.840.10008.1.2.2";
    return syntax.starts_with("1.2.840.10008.1.2") && syntax != "1.2.840.10008.1.2.1.99";
  }

  template <typename T>
  std::optional<T> number() {
    return is_big_ ? reader_.big_endian<T>() : reader_.little_endian<T>();
  }

  std::optional<Element> next() {
    const auto group = number<std::uint16_t>();
    const auto member = number<std::uint16_t>();
    if (!group || !member) return std::nullopt;
    Element element{static_cast<std::uint32_t>(*group) << 16 | *member};
    if (!is_explicit_ || *group == 0xfffe) return with_long_length(element);
    const auto type = reader_.take(2);
    if (!type) return std::nullopt;
    const std::string vr = text_of(*type);
    constexpr std::string_view kLong = "OB OD OF OL OV OW SQ SV UC UN UR UT UV";
    constexpr std::string_view kShort = "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US";
    element.is_sequence = vr == "SQ";
    if (vr.size() == 2 && kLong.find(vr) != std::string_view::npos) {
      if (!reader_.take(2)) return std::nullopt;
      return with_long_length(element);
    }
    const auto length = number<std::uint16_t>();
    if (!length || vr.size() != 2 || kShort.find(vr) == std::string_view::npos) return std::nullopt;
    element.length = *length;
    return element;
  }

  std::optional<Element> with_long_length(Element element) {
    const auto length = number<std::uint32_t>();
    if (!length) return std::nullopt;
    element.length = *length;
    return element;
  }

  // Up to the delimiter `end`, or to the end of the bytes where it is 0. Tags of elements ascend (PS3.5, 7.1).
  bool walk_elements(std::uint32_t end, int depth) {
    std::uint32_t last = 0;
    while (end != 0 || reader_.remaining() > 0) {
      const auto element = next();
      if (!element) return false;
      if (end != 0 && element->tag == end) return element->length == 0;
      const bool is_item = element->tag == kItem;
      if (is_item != (end == kSequenceEnd) || (!is_item && element->tag <= last)) return false;
      last = element->tag;
      has_pixels_ = has_pixels_ || (depth == 0 && last == 0x7fe00010);
      if (!walk_value(*element, depth)) return false;
    }
    return true;
  }

  bool walk_value(const Element& element, int depth) {
    if (element.length != kUndefinedLength) {
      const auto value = reader_.take(element.length);
      if (!value || !element.is_sequence) return value.has_value();
      Walker inner(*value);
      inner.is_explicit_ = is_explicit_;
      inner.is_big_ = is_big_;
      return depth < kMaxDepth && inner.walk_items(depth + 1);
    }
    if (depth >= kMaxDepth) return false;
    return walk_elements(element.tag == kItem ? kItemEnd : kSequenceEnd, depth + 1);
  }

  // The items of a sequence of defined length.
  bool walk_items(int depth) {
    while (reader_.remaining() > 0) {
      const auto item = next();
      if (!item || item->tag != kItem || !walk_value(*item, depth)) return false;
    }
    return true;
  }

  ByteReader reader_;
  bool is_explicit_ = true;
  bool is_big_ = false;
  bool has_pixels_ = false;
};

}  // namespace

bool is_dicom_structure(std::span<const std::byte> file) {
  return Walker(file).walk();
}

}  // namespace scanknit
