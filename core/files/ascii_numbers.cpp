#include "core/files/ascii_numbers.h"

#include <charconv>

namespace scanknit {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

template <typename T>
std::optional<T> parse(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

std::string_view take_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::optional<double> parse_double(std::string_view word) {
  return parse<double>(word);
}

std::optional<float> parse_float(std::string_view word) {
  return parse<float>(word);
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  return parse<std::int64_t>(word);
}

}  // namespace scanknit
