// The bytes of a plan's file, little-endian: written by functions, read by PlanReader. Private to the room.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

#include "core/files/byte_reader.h"
#include "core/files/little_endian.h"

namespace scanknit {

inline void append_count(std::string& bytes, std::size_t count) {
  append_little_endian(bytes, static_cast<std::uint64_t>(count));
}

inline void append_text(std::string& bytes, std::string_view text) {
  append_count(bytes, text.size());
  bytes += text;
}

/// Reads what the functions above wrote. After a read that does not fit, everything is 0 and is_whole() false.
class PlanReader {
 public:
  explicit PlanReader(ByteReader reader) : reader_(reader) {}
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  [[nodiscard]] bool is_at_end() const { return reader_.remaining() == 0; }
  /// From now on is_whole() is false unless `is_sound`.
  void require(bool is_sound) { is_whole_ = is_whole_ && is_sound; }

  template <typename T>
  [[nodiscard]] T number() {
    const auto value = reader_.little_endian<T>();
    require(value.has_value());
    return is_whole_ ? *value : T{};
  }

  [[nodiscard]] std::size_t size() { return static_cast<std::size_t>(number<std::uint64_t>()); }

  /// A count of things that follow and take at least `least_bytes` each.
  [[nodiscard]] std::size_t count(std::size_t least_bytes) {
    const std::size_t count = size();
    require(count <= reader_.remaining() / least_bytes);
    return is_whole_ ? count : 0;
  }

  [[nodiscard]] std::string text() {
    std::string text;
    const auto bytes = reader_.take(count(1));
    if (!bytes) return text;
    std::transform(bytes->begin(), bytes->end(), std::back_inserter(text),
                   [](std::byte byte) { return static_cast<char>(byte); });
    return text;
  }

 private:
  ByteReader reader_;
  bool is_whole_ = true;
};

}  // namespace scanknit
