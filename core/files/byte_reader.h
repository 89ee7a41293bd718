// ByteReader: the only way to read raw bytes that we parse ourselves. Bounded, explicit about byte order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace scanknit {

/// Reads a span from front to back. A read that does not fit returns nothing and does not move the position.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - offset_; }
  [[nodiscard]] std::size_t offset() const { return offset_; }

  [[nodiscard]] std::optional<std::span<const std::byte>> take(std::size_t count) {
    if (count > remaining()) return std::nullopt;
    const auto part = bytes_.subspan(offset_, count);
    offset_ += count;
    return part;
  }

  /// T: an integer or float of 1, 2, 4 or 8 bytes.
  template <typename T>
  [[nodiscard]] std::optional<T> little_endian() {
    return read<T, std::endian::little>();
  }
  template <typename T>
  [[nodiscard]] std::optional<T> big_endian() {
    return read<T, std::endian::big>();
  }

 private:
  template <typename T, std::endian Order>
  [[nodiscard]] std::optional<T> read() {
    const auto part = take(sizeof(T));
    if (!part) return std::nullopt;
    std::byte raw[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      raw[i] = (*part)[Order == std::endian::native ? i : sizeof(T) - 1 - i];
    }
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  std::span<const std::byte> bytes_;
  std::size_t offset_ = 0;
};

}  // namespace scanknit
