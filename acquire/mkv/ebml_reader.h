// EBML (RFC 8794), the tree of elements that Matroska files consist of: an id, a size, then so many bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"

namespace scanknit {

/// Where an element is; its content is not read yet.
struct EbmlElement {
  std::uint32_t id = 0;  ///< with its marker bits, as the format's tables list it
  std::uint64_t start = 0;
  std::uint64_t content = 0;
  std::uint64_t end = 0;    ///< the place after it, never after its parent's end
  bool is_open = false;     ///< its size is not known: it ends where an element comes that cannot be in it
  bool is_cut_off = false;  ///< its size says more than its parent holds

  [[nodiscard]] std::uint64_t size() const { return end - content; }
};

/// Goes through the elements in a part of a file. Reads their first bytes only.
class EbmlWalk {
 public:
  /// From `at` to `end`, which is at most the file's size. At most `steps` elements are visited.
  EbmlWalk(const RandomAccess& file, std::uint64_t at, std::uint64_t end, std::uint64_t& steps)
      : file_(file), at_(at), end_(end), steps_(steps) {}

  /// The next element; nothing at the end, and at what is no element (see is_damaged()).
  [[nodiscard]] std::optional<EbmlElement> next();

  /// Goes on at `at`, which must not be before the last element's content: for elements without a known size.
  void continue_at(std::uint64_t at) { at_ = at; }

  /// The walk ended before the end.
  [[nodiscard]] bool is_damaged() const { return is_damaged_; }
  [[nodiscard]] std::uint64_t at() const { return at_; }

 private:
  const RandomAccess& file_;
  std::uint64_t at_, end_;
  std::uint64_t& steps_;
  bool is_damaged_ = false;
};

/// A number of variable length (1 to 8 bytes, the first set bit says how many) at the front of `bytes`.
struct EbmlNumber {
  std::uint64_t value = 0;  ///< without the marker bit
  std::size_t length = 0;
  bool is_unknown = false;  ///< all bits are set: for sizes, "unknown"
};
[[nodiscard]] std::optional<EbmlNumber> read_ebml_number(std::span<const std::byte> bytes);

// The content of an element; nothing if it is cut off, too long, or cannot be read.
[[nodiscard]] std::optional<std::uint64_t> ebml_unsigned(const RandomAccess& file, const EbmlElement& element);
[[nodiscard]] std::optional<std::string> ebml_text(const RandomAccess& file, const EbmlElement& element);
[[nodiscard]] std::optional<std::vector<std::byte>> ebml_bytes(const RandomAccess& file, const EbmlElement& element,
                                                               std::uint64_t most_bytes);

}  // namespace scanknit
