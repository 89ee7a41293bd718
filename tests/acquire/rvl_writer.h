// Depth packed by RVL, as tests write it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "acquire/mcap/byte_appender.h"

namespace scanknit::test {

/// Written by Wilson's description (2017), apart from the reader.
class RvlWriter {
 public:
  explicit RvlWriter(std::span<const std::uint16_t> pixels) {
    std::int32_t previous = 0;
    for (std::size_t i = 0; i < pixels.size();) {
      const auto run = [&](bool is_empty) {
        std::size_t end = i;
        while (end < pixels.size() && (pixels[end] == 0) == is_empty) ++end;
        return end - i;
      };
      const std::size_t empty = run(true);
      number(static_cast<std::uint32_t>(empty));
      i += empty;
      const std::size_t full = run(false);
      number(static_cast<std::uint32_t>(full));
      for (const std::size_t end = i + full; i < end; ++i) {
        const std::int32_t step = pixels[i] - previous;
        previous = pixels[i];
        number(static_cast<std::uint32_t>(step < 0 ? -2 * step - 1 : 2 * step));
      }
    }
    while (nibbles_.size() % 8 != 0) nibbles_.push_back(0);
  }

  [[nodiscard]] std::vector<std::byte> bytes() const {
    std::vector<std::byte> packed;
    for (std::size_t word = 0; word < nibbles_.size(); word += 8) {
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < 8; ++i) value = value << 4 | nibbles_[word + i];
      ByteAppender(packed).little_endian(value);
    }
    return packed;
  }

 private:
  void number(std::uint32_t value) {
    do {
      nibbles_.push_back((value & 7) | (value > 7 ? 8 : 0));
      value >>= 3;
    } while (value != 0);
  }

  std::vector<std::uint32_t> nibbles_;
};

}  // namespace scanknit::test
