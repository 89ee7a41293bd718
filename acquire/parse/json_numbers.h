// Numbers of JSON objects that are not trusted.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "core/files/read_file.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

/// Nothing: the key is missing, or its value is no number.
[[nodiscard]] inline std::optional<double> json_number(const nlohmann::json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

/// `json` as a list of exactly `count` numbers.
[[nodiscard]] inline std::optional<std::vector<double>> json_list(const nlohmann::json& json, std::size_t count) {
  if (!json.is_array() || json.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const auto& value : json) {
    if (!value.is_number()) return std::nullopt;
    numbers.push_back(value.get<double>());
  }
  return numbers;
}

[[nodiscard]] inline std::optional<std::vector<double>> json_numbers(const nlohmann::json& json, const char* key,
                                                                     std::size_t count) {
  const auto found = json.find(key);
  return found == json.end() ? std::nullopt : json_list(*found, count);
}

/// The width or height of a picture: 1 to 2^20.
[[nodiscard]] inline std::optional<int> json_side(const nlohmann::json& json, const char* key) {
  constexpr double kMostSide = 1 << 20;
  const auto side = json_number(json, key);
  return side && *side >= 1 && *side <= kMostSide ? std::optional(static_cast<int>(*side)) : std::nullopt;
}

/// The file's object. Errors (kInput): it cannot be read, or is something else.
[[nodiscard]] inline Result<nlohmann::json> read_json_object(const std::filesystem::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object()) return Error{ErrorCode::kInput, "not a JSON object, or truncated", path.string()};
  return json;
}

}  // namespace scanknit
