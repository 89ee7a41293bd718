// Reads values of a report.json. Any of them may be missing or have another type, because the file may be from another
// version or another program. Private to the page: the only header that includes the JSON library.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.h"

namespace scanknit {

using ReportJson = nlohmann::ordered_json;

/// Errors (kInput): no JSON object, or one that is nested too deeply.
[[nodiscard]] Result<ReportJson> parse_report(std::string_view text);

/// The value at `pointer` ("/mesh/triangles"), a path of keys; null when there is none. Refers to `json`.
[[nodiscard]] const ReportJson& value_at(const ReportJson& json, std::string_view pointer);

/// The list or object at `pointer`; an empty one when there is none.
[[nodiscard]] const ReportJson& list_at(const ReportJson& json, std::string_view pointer);
[[nodiscard]] const ReportJson& object_at(const ReportJson& json, std::string_view pointer);

/// The value as a finite number; nothing if it is none.
[[nodiscard]] std::optional<double> number_of(const ReportJson& value);
[[nodiscard]] std::optional<double> number_at(const ReportJson& json, std::string_view pointer);

/// The text at `pointer`, not escaped; empty when there is none.
[[nodiscard]] std::string text_at(const ReportJson& json, std::string_view pointer);

/// "fusion.voxel_size" and "0.002" for every value in `json`, at any depth; both not escaped. At most `most` rows.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> flattened(const ReportJson& json, std::size_t most);

}  // namespace scanknit
