#include "acquire/usb/usb_numbers.h"

#include <array>
#include <charconv>
#include <cstdio>

namespace scanknit {
namespace {

std::optional<std::uint16_t> hex_number(std::string_view text) {
  std::uint16_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 4 || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<UsbNumbers> parse_usb_numbers(std::string_view text) {
  if (text.size() != 9 || text[4] != ':') return std::nullopt;
  const auto vendor = hex_number(text.substr(0, 4)), product = hex_number(text.substr(5));
  if (!vendor || !product) return std::nullopt;
  return UsbNumbers{*vendor, *product};
}

std::string hex_text(std::uint16_t number) {
  std::array<char, 5> text{};
  std::snprintf(text.data(), text.size(), "%04x", number);
  return text.data();
}

}  // namespace scanknit
