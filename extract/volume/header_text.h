// Words and numbers of a text header, whatever the locale.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/files/ascii_numbers.h"

namespace scanknit {

[[nodiscard]] inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The parts between any of `separators`, empty ones left out.
[[nodiscard]] inline std::vector<std::string_view> split_words(std::string_view text,
                                                               std::string_view separators = " \t\r\n") {
  std::vector<std::string_view> words;
  for (std::size_t end = 0; end < text.size();) {
    const std::size_t begin = text.find_first_not_of(separators, end);
    if (begin == std::string_view::npos) break;
    end = std::min(text.find_first_of(separators, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
  }
  return words;
}

/// Exactly `count` numbers, one a word.
template <typename Number>
[[nodiscard]] std::optional<std::vector<Number>> parse_numbers(const std::vector<std::string_view>& words,
                                                               std::size_t count) {
  if (words.size() != count) return std::nullopt;
  std::vector<Number> numbers;
  for (const std::string_view word : words) {
    const auto number = parse_number<Number>(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace scanknit
