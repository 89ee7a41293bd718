// Words of YAML: without blanks around them, and without quotes.
#pragma once

#include <string_view>

namespace scanknit {

[[nodiscard]] inline std::string_view without_blanks(std::string_view text) {
  constexpr const char* kBlanks = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// Plain, or in single or double quotes.
[[nodiscard]] inline std::string_view without_quotes(std::string_view text) {
  text = without_blanks(text);
  const bool is_quoted =
      text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\'');
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

}  // namespace scanknit
