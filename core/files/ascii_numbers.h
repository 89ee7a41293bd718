// Words and numbers of text formats; independent of the locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace scanknit {

/// Cuts the next word (no blanks, no line ends) off the front of `rest`; empty at the end.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// Cuts the next line off the front of `rest`, without its line end (LF or CR LF).
[[nodiscard]] std::string_view take_line(std::string_view& rest);

/// The whole word as a number, or nothing. A leading '+' is allowed.
[[nodiscard]] std::optional<double> parse_double(std::string_view word);
[[nodiscard]] std::optional<float> parse_float(std::string_view word);
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace scanknit
