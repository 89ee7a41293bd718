#include "app/calibrate/target_file.h"

#include <fmt/format.h>

#include <set>

#include "app/config/yaml_node.h"
#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"
#include "core/files/read_file.h"
#include "core/limits.h"

namespace scanknit {
namespace {

/// Sets one value of `target`. Returns what was expected if it is not that; empty: it was set.
std::string set_value(CalibrationTarget& target, const std::string& key, const std::string& text) {
  if (key == "type") {
    target.type = text == "charuco" ? TargetType::kCharuco : TargetType::kAprilGrid;
    return text == "charuco" || text == "aprilgrid" ? "" : "aprilgrid or charuco";
  }
  if (key == "size") {
    const auto length = parse_length(text);
    if (length) target.size_m = length->metres;
    return length ? "" : "a length such as 30 mm";
  }
  const auto count = parse_number<int>(text);
  if (count) (key == "columns" ? target.columns : target.rows) = *count;
  return count ? "" : "a whole number";
}

}  // namespace

std::string target_file_text(const CalibrationTarget& target) {
  const bool is_grid = target.type == TargetType::kAprilGrid;
  return fmt::format(
      "# A board for `scanknit calibrate`. If the printed lines of 100 mm measure M mm, multiply size by M / 100.\n"
      "type: {}  # tags of the family 36h11, from 0, row by row\n"
      "columns: {}  # of {}\n"
      "rows: {}\n"
      "size: {}  # {}\n",
      is_grid ? "aprilgrid" : "charuco", target.columns, is_grid ? "tags" : "squares", target.rows,
      format_length(target.size_m), is_grid ? "side of a tag's black border" : "side of a square");
}

Result<CalibrationTarget> read_target_file(const std::filesystem::path& path) {
  const auto text = read_text_file(path, Limits{}.max_config_bytes);
  if (!text) return text.error();
  const auto refuse = [&](int line, int column, std::string message) {
    return Error{ErrorCode::kConfig, std::move(message), fmt::format("{}:{}:{}", path.string(), line, column)};
  };
  const auto parsed = parse_yaml(*text);
  if (const auto* error = std::get_if<YamlError>(&parsed)) return refuse(error->line, error->column, error->message);
  const YamlNode& root = std::get<YamlNode>(parsed);
  if (root.kind != YamlNode::Kind::kMap) {
    return refuse(root.line, root.column,
                  "expected type, columns, rows and size, as `scanknit calibrate target` writes");
  }
  CalibrationTarget target;
  std::set<std::string> missing = {"type", "columns", "rows", "size"};
  for (std::size_t i = 0; i + 1 < root.children.size(); i += 2) {
    const YamlNode& key = root.children[i];
    const YamlNode& value = root.children[i + 1];
    if (missing.erase(key.text) == 0) {
      return refuse(key.line, key.column,
                    fmt::format("unknown or repeated key '{}'; known are type, columns, rows, size", key.text));
    }
    const std::string expected = set_value(target, key.text, value.text);
    if (expected.empty()) continue;
    return refuse(value.line, value.column, fmt::format("{}: expected {}, got '{}'", key.text, expected, value.text));
  }
  if (!missing.empty()) return refuse(root.line, root.column, fmt::format("'{}' is missing", *missing.begin()));
  if (auto valid = validate(target); !valid) return refuse(root.line, root.column, valid.error().message);
  return target;
}

}  // namespace scanknit
