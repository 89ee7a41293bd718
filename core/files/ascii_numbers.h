// Words and numbers of text formats; independent of the locale.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace scanknit {

/// Cuts the next word (no blanks, no line ends) off the front of `rest`; empty at the end.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// Cuts the next line off the front of `rest`, without its line end (LF or CR LF).
[[nodiscard]] std::string_view take_line(std::string_view& rest);

/// The letters A to Z as a to z.
[[nodiscard]] std::string lower_case(std::string_view text);

/// The whole word as a number, or nothing. A leading '+' is allowed; "nan" and "inf" are floats and doubles.
template <typename Number>
[[nodiscard]] std::optional<Number> parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);  // from_chars does not know a plus sign
  Number number{};
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (fault != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return number;
}

[[nodiscard]] inline std::optional<double> parse_double(std::string_view word) {
  return parse_number<double>(word);
}
[[nodiscard]] inline std::optional<float> parse_float(std::string_view word) {
  return parse_number<float>(word);
}
[[nodiscard]] inline std::optional<std::int64_t> parse_integer(std::string_view word) {
  return parse_number<std::int64_t>(word);
}

}  // namespace scanknit
