// File names that carry a frame number, "frame-000017.depth.png".
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace scanknit {

/// The number between `prefix` and `suffix`; nothing when the name has another form.
[[nodiscard]] inline std::optional<std::uint64_t> numbered_name(std::string_view name, std::string_view prefix,
                                                                std::string_view suffix) {
  if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix)) {
    return std::nullopt;
  }
  const std::string_view digits = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  std::uint64_t number = 0;
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (code != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

}  // namespace scanknit
