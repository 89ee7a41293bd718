// Bytes written by hand, for the tests of what cameras send.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

namespace scanknit::test {

/// Little endian, front to back.
class Bytes {
 public:
  Bytes() = default;
  Bytes(std::initializer_list<int> values) {
    for (const int value : values) u8(value);
  }
  Bytes& u8(int value) { return bytes_.push_back(static_cast<std::byte>(value)), *this; }
  Bytes& u16(std::uint32_t value) { return number(value, 2); }
  Bytes& u32(std::uint32_t value) { return number(value, 4); }
  Bytes& f32(float value);
  Bytes& text(std::string_view text) {
    for (const char c : text) u8(c);
    return *this;
  }
  Bytes& fill(std::size_t count, int value = 0) {
    return bytes_.resize(bytes_.size() + count, std::byte(value)), *this;
  }
  Bytes& add(const Bytes& more) {
    bytes_.insert(bytes_.end(), more.bytes_.begin(), more.bytes_.end());
    return *this;
  }

  [[nodiscard]] std::span<const std::byte> span() const { return bytes_; }
  [[nodiscard]] const std::vector<std::byte>& vector() const { return bytes_; }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  std::byte& operator[](std::size_t i) { return bytes_[i]; }

 private:
  Bytes& number(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) u8(static_cast<int>((value >> (8 * i)) & 0xFF));
    return *this;
  }
  std::vector<std::byte> bytes_;
};

inline Bytes& Bytes::f32(float value) {
  std::uint32_t bits = 0;
  static_assert(sizeof(bits) == sizeof(value));
  __builtin_memcpy(&bits, &value, sizeof(bits));
  return u32(bits);
}

/// A descriptor: its length goes before it.
inline Bytes descriptor(const Bytes& body) {
  Bytes out;
  out.u8(static_cast<int>(body.size()) + 1).add(body);
  return out;
}

/// The GUID of a format: a code of four characters and the tail that all of them share.
inline Bytes format_guid(std::string_view code) {
  Bytes out;
  return out.text(code).add({0x00, 0x00, 0x10, 0x00, 0x80, 0x00, 0x00, 0xAA, 0x00, 0x38, 0x9B, 0x71});
}

}  // namespace scanknit::test
