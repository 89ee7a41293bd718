// CdrReader: reads a message of ROS 2, which is plain CDR (OMG Common Object Request Broker Architecture 3.3, part 2,
// section 9.3) after four bytes that say its byte order (OMG DDSI-RTPS 2.2, section 10.2); or one of ROS 1, which has
// the same fields in the same order, little endian, none of them aligned, strings without a NUL (wiki.ros.org/msg).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "acquire/bag/ros_message.h"
#include "core/files/byte_reader.h"

namespace scanknit {

/// Reads a message from front to back. A read that does not fit returns nothing.
class CdrReader {
 public:
  /// Nothing: too short, or neither CDR_BE nor CDR_LE.
  [[nodiscard]] static std::optional<CdrReader> open(const RosMessage& message) {
    if (message.encoding == RosEncoding::kRos1) return CdrReader(message.bytes, true, true);
    constexpr std::size_t kHeader = 4;
    ByteReader reader(message.bytes);
    const auto encoding = reader.big_endian<std::uint16_t>();
    if (message.bytes.size() < kHeader || *encoding > 1) return std::nullopt;
    return CdrReader(message.bytes.subspan(kHeader), *encoding == 1, false);
  }

  /// A header has a number in front.
  [[nodiscard]] bool is_ros1() const { return is_ros1_; }

  /// T: an integer or float of 1, 2, 4 or 8 bytes, which in CDR lies at a multiple of its size from the message's
  /// begin.
  template <typename T>
  [[nodiscard]] std::optional<T> number() {
    const std::size_t beyond = is_ros1_ ? 0 : reader_.offset() % sizeof(T);
    if (beyond != 0 && !reader_.take(sizeof(T) - beyond)) return std::nullopt;
    return is_little_ ? reader_.little_endian<T>() : reader_.big_endian<T>();
  }

  /// As many numbers as `to` has places, an array or vector. False: they do not fit.
  template <typename Numbers>
  [[nodiscard]] bool numbers(Numbers& to) {
    for (auto& value : to) {
      const auto next = number<typename Numbers::value_type>();
      if (!next) return false;
      value = *next;
    }
    return true;
  }

  /// A string: its length, in CDR with the NUL at its end, which is left out.
  [[nodiscard]] std::optional<std::string> text() {
    const auto bytes = sequence();
    if (!bytes) return std::nullopt;
    std::string text(bytes->size(), '\0');
    for (std::size_t i = 0; i < text.size(); ++i) text[i] = static_cast<char>((*bytes)[i]);
    if (!text.empty() && text.back() == '\0') text.pop_back();
    return text;
  }

  /// A sequence of bytes after its length.
  [[nodiscard]] std::optional<std::span<const std::byte>> sequence() {
    const auto length = number<std::uint32_t>();
    return length ? reader_.take(*length) : std::nullopt;
  }

 private:
  CdrReader(std::span<const std::byte> body, bool is_little, bool is_ros1)
      : reader_(body), is_little_(is_little), is_ros1_(is_ros1) {}

  ByteReader reader_;
  bool is_little_;
  bool is_ros1_;
};

}  // namespace scanknit
