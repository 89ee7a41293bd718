// Natural order of file names: numbers inside them count as numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>

#include "extract/volume/header_text.h"

namespace scanknit {

/// Whether `a` comes before `b`: "slice_2" before "slice_10". Numbers may be of any length.
[[nodiscard]] inline bool is_naturally_before(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto take_number = [&](std::string_view& text) {
    while (text.size() > 1 && text[0] == '0' && is_digit(text[1])) text.remove_prefix(1);
    std::size_t length = 0;
    while (length < text.size() && is_digit(text[length])) ++length;
    const std::string_view number = text.substr(0, length);
    text.remove_prefix(length);
    return number;
  };
  std::string_view rest_a = a, rest_b = b;
  while (!rest_a.empty() && !rest_b.empty()) {
    if (is_digit(rest_a[0]) && is_digit(rest_b[0])) {
      const std::string_view number_a = take_number(rest_a), number_b = take_number(rest_b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
    } else {
      if (rest_a[0] != rest_b[0]) return rest_a[0] < rest_b[0];
      rest_a.remove_prefix(1);
      rest_b.remove_prefix(1);
    }
  }
  if (rest_a.empty() != rest_b.empty()) return rest_a.empty();
  return a < b;  // "1" and "01"
}

/// The number after a's where the names differ in one number and b's is not the next: 2 for "s_001.png", "s_003.png".
[[nodiscard]] inline std::optional<std::uint64_t> skipped_number(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto differ = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
  std::size_t begin = differ;
  while (begin > 0 && is_digit(a[begin - 1])) --begin;
  const auto number_end = [&](std::string_view text) {
    return static_cast<std::size_t>(
        std::find_if_not(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), is_digit) - text.begin());
  };
  const std::size_t end_a = number_end(a), end_b = number_end(b);
  if (a.substr(end_a) != b.substr(end_b)) return std::nullopt;
  const auto number_a = parse_number<std::uint64_t>(a.substr(begin, end_a - begin));
  const auto number_b = parse_number<std::uint64_t>(b.substr(begin, end_b - begin));
  if (!number_a || !number_b || *number_b <= *number_a || *number_b - *number_a == 1) return std::nullopt;
  return *number_a + 1;
}

}  // namespace scanknit
