// CdrWriter: messages of ROS 2 as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "acquire/mcap/byte_appender.h"

namespace scanknit {

/// Appends the fields of a message in their order: plain CDR, little endian, each number aligned to its size (OMG
/// DDS-RTPS, 10.2; CORBA 9.3).
class CdrWriter {
 public:
  template <typename T>
  void number(T value) {
    while ((bytes_.size() - kHead) % sizeof(T) != 0) bytes_.push_back({});
    ByteAppender(bytes_).little_endian(value);
  }
  void numbers(std::span<const double> values) {
    for (const double value : values) number(value);
  }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    ByteAppender(bytes_).append(std::as_bytes(std::span(text)));
    bytes_.push_back({});
  }
  /// std_msgs/Header.
  void header(std::int64_t time_ns, std::string_view frame_id) {
    constexpr std::int64_t kSecond_ns = 1'000'000'000;
    number(static_cast<std::int32_t>(time_ns / kSecond_ns));
    number(static_cast<std::uint32_t>(time_ns % kSecond_ns));
    text(frame_id);
  }
  /// A sequence of bytes.
  void sequence(std::span<const std::byte> bytes) {
    number(static_cast<std::uint32_t>(bytes.size()));
    ByteAppender(bytes_).append(bytes);
  }

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kHead = 4;
  std::vector<std::byte> bytes_{{}, std::byte{1}, {}, {}};  // plain CDR, little endian, no options
};

}  // namespace scanknit
