// ByteAppender: writes what ByteReader reads: numbers and texts as bytes, little endian.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace scanknit {

/// Appends to a vector that it does not own.
class ByteAppender {
 public:
  explicit ByteAppender(std::vector<std::byte>& bytes) : bytes_(bytes) {}

  /// T: an integer or float of 1, 2, 4 or 8 bytes.
  template <typename T>
  void little_endian(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    put(at, value);
  }

  void append(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }

  /// Appends its length in 32 bits, then its bytes.
  void text(std::string_view text) {
    little_endian(static_cast<std::uint32_t>(text.size()));
    append(std::as_bytes(std::span(text)));
  }

  /// Overwrites existing bytes: at + sizeof(T) <= size.
  template <typename T>
  void put(std::size_t at, T value) {
    std::byte raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes_[at + i] = raw[std::endian::native == std::endian::little ? i : sizeof(T) - 1 - i];
    }
  }

 private:
  std::vector<std::byte>& bytes_;
};

}  // namespace scanknit
