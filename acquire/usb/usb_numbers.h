// A USB device's vendor and product in the usual form: "8086:0b07".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace scanknit {

struct UsbNumbers {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;

  bool operator==(const UsbNumbers&) const = default;
};

/// Nothing: not two hexadecimal numbers of four digits.
[[nodiscard]] std::optional<UsbNumbers> parse_usb_numbers(std::string_view text);

/// Four hexadecimal digits in lower case.
[[nodiscard]] std::string hex_text(std::uint16_t number);

}  // namespace scanknit
