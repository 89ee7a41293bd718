#include "core/files/quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace scanknit {
namespace {

struct NumberAndUnit {
  double number = 0;
  std::string_view unit;
};

std::string_view without_spaces_around(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

std::optional<NumberAndUnit> split_unit(std::string_view text) {
  text = without_spaces_around(text);
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  std::size_t unit_at = text.size();
  while (unit_at > 0 && is_letter(text[unit_at - 1])) --unit_at;
  const auto number = parse_finite(without_spaces_around(text.substr(0, unit_at)));
  if (!number) return std::nullopt;
  return NumberAndUnit{*number, text.substr(unit_at)};
}

}  // namespace

std::optional<double> parse_finite(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Length> parse_length(std::string_view text) {
  const auto parts = split_unit(text);
  if (!parts) return std::nullopt;
  // Dividing by a whole number rounds once, so that "3mm" and "0.003" are the same bits.
  if (parts->unit.empty()) return Length{parts->number, false};
  if (parts->unit == "m") return Length{parts->number, true};
  if (parts->unit == "cm") return Length{parts->number / 100, true};
  if (parts->unit == "mm") return Length{parts->number / 1000, true};
  return std::nullopt;
}

std::optional<std::int64_t> parse_memory_mib(std::string_view text) {
  const auto parts = split_unit(text);
  if (!parts) return std::nullopt;
  double mebibytes = parts->number;
  if (parts->unit == "GiB") {
    mebibytes *= 1024;
  } else if (parts->unit == "KiB") {
    mebibytes /= 1024;
  } else if (!parts->unit.empty() && parts->unit != "MiB") {
    return std::nullopt;
  }
  constexpr double kBeyondAnyMachine = 1e12;
  if (std::abs(mebibytes) > kBeyondAnyMachine) return std::nullopt;
  return static_cast<std::int64_t>(mebibytes > 0 ? std::ceil(mebibytes) : std::floor(mebibytes));
}

std::string format_number(double value) {
  std::array<char, 64> buffer;  // the shortest form of a double has at most 24 characters, this range at most 32
  const bool is_readable = value == 0 || (std::abs(value) >= 1e-6 && std::abs(value) < 1e15);
  const auto form = is_readable ? std::chars_format::fixed : std::chars_format::scientific;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, form);
  return error == std::errc{} ? std::string(buffer.data(), end) : fmt::format("{}", value);
}

std::string format_length(double metres) {
  if (metres == 0) return "0";
  constexpr double kFromHereInMetres = 0.1;
  if (std::abs(metres) < kFromHereInMetres) {
    // Ten digits are more than anyone writes; a value that needs more is written in metres.
    std::string text = fmt::format("{:.10g} mm", metres * 1000);
    const auto back = parse_length(text);
    if (back && back->metres == metres) return text;
  }
  return format_number(metres) + " m";
}

std::string format_memory_mib(std::int64_t mebibytes) {
  if (mebibytes != 0 && mebibytes % 1024 == 0) return fmt::format("{} GiB", mebibytes / 1024);
  return fmt::format("{} MiB", mebibytes);
}

}  // namespace scanknit
