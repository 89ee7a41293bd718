#include "app/config/config_print.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "acquire/sensor/sensor_profile.h"
#include "app/config/config_schema.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

template <typename... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // clang 14 does not deduce it

std::string numbers_text(const std::vector<double>& numbers) {
  std::vector<std::string> words;
  for (const double number : numbers) words.push_back(format_number(number));
  return fmt::format("[{}]", fmt::join(words, ", "));
}

std::string camera_text(const CameraModel& model) {
  const CameraIntrinsics& c = model.intrinsics;
  const bool is_plain = c.width == 0 && model.distortion == Distortion{};
  if (is_plain) return numbers_text({c.fx, c.fy, c.cx, c.cy});
  const std::string size = c.width == 0 ? "" : fmt::format("width: {}, height: {}, ", c.width, c.height);
  return fmt::format("{{{}fx: {}, fy: {}, cx: {}, cy: {}, distortion: {}}}", size, format_number(c.fx),
                     format_number(c.fy), format_number(c.cx), format_number(c.cy),
                     numbers_text({model.distortion.begin(), model.distortion.end()}));
}

/// The value as YAML.
/// A text as YAML: in single quotes where it would mean something else without.
std::string yaml_text(const std::string& text) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./-";
  const bool is_null = text == "null" || text == "Null" || text == "NULL";
  const bool is_plain = text.find_first_not_of(kPlain) == std::string::npos && text != "-" && !is_null;
  if (is_plain && !text.empty()) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string value_text(const ConfigKey& key, const ConfigValue& value) {
  return std::visit(
      Overloaded{
          [](std::monostate) { return std::string("auto"); },
          [](bool flag) { return std::string(flag ? "true" : "false"); },
          [&](std::int64_t whole) {
            return key.type == ConfigType::kMemory ? format_memory_mib(whole) : fmt::format("{}", whole);
          },
          [&](double number) {
            return key.type == ConfigType::kLength ? format_length(number) : format_number(number);
          },
          [&](const std::string& word) { return key.type == ConfigType::kEnum ? word : yaml_text(word); },
          [](const std::vector<std::string>& words) { return fmt::format("[{}]", fmt::join(words, ", ")); },
          [](const CameraModel& model) { return camera_text(model); },
          [](const std::shared_ptr<const ScannerCamera>& camera) { return yaml_text(camera->file); },
      },
      value);
}

Json value_json(const ConfigValue& value) {
  return std::visit(Overloaded{
                        [](std::monostate) { return Json(nullptr); },
                        [](const CameraModel& model) {
                          const CameraIntrinsics& c = model.intrinsics;
                          return Json{{"width", c.width},
                                      {"height", c.height},
                                      {"fx", c.fx},
                                      {"fy", c.fy},
                                      {"cx", c.cx},
                                      {"cy", c.cy},
                                      {"distortion", model.distortion}};
                        },
                        [](const std::shared_ptr<const ScannerCamera>& camera) { return Json(camera->file); },
                        [](const auto& plain) { return Json(plain); },
                    },
                    value);
}

std::vector<std::string> split_name(const std::string& name) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', begin)) {
    parts.push_back(name.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(name.substr(begin));
  return parts;
}

/// Wraps `text` into lines of at most `width`, unless a word is longer.
std::vector<std::string> wrap(const std::string& text, std::size_t width) {
  std::vector<std::string> lines(1);
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
    begin = end + 1;
  }
  return lines;
}

/// The allowed values: "number of voxels", "length, 0.0002..0.1 m".
std::string allowed_text(const ConfigKey& key) {
  const std::string range = format_config_range(key);
  switch (key.type) {
    case ConfigType::kBool: return "true, false";
    case ConfigType::kEnum: return range;
    case ConfigType::kList: return "some of " + range;
    case ConfigType::kTopic: return "auto, a topic's name";
    case ConfigType::kPath: return "auto, a path";
    case ConfigType::kCamera: return "auto, a file";
    case ConfigType::kIntrinsics: return "auto, [fx, fy, cx, cy], a map, a file";
    default: break;
  }
  const bool range_says_unit = range.ends_with(" " + key.unit);
  const std::string unit = key.unit.empty() || range_says_unit ? "" : " " + key.unit;
  return (key.allows_auto ? "auto, " : "") + range + unit;
}

Json number_schema(const ConfigKey& key, const char* type) {
  return {{"type", type}, {"minimum", key.minimum}, {"maximum", key.maximum}};
}

Json text_schema(const char* pattern) {
  return {{"type", "string"}, {"pattern", pattern}};
}

Json intrinsics_schema() {
  const Json number = {{"type", "number"}};
  const Json pixels = {{"type", "integer"}, {"minimum", 1}};
  const Json list = {{"type", "array"}, {"items", number}, {"minItems", 4}, {"maxItems", 4}};
  const Json distortion = {{"type", "array"}, {"items", number}, {"minItems", 5}, {"maxItems", 5}};
  const Json map = {{"type", "object"},
                    {"properties",
                     {{"width", pixels},
                      {"height", pixels},
                      {"fx", number},
                      {"fy", number},
                      {"cx", number},
                      {"cy", number},
                      {"distortion", distortion}}},
                    {"required", {"fx", "fy", "cx", "cy"}},
                    {"additionalProperties", false}};
  return {{"anyOf", {list, map, {{"type", "string"}}}}};
}

Json value_schema(const ConfigKey& key) {
  const Json words = {{"enum", key.choices}};
  switch (key.type) {
    case ConfigType::kBool: return {{"type", "boolean"}};
    case ConfigType::kInteger: return number_schema(key, "integer");
    case ConfigType::kNumber: return number_schema(key, "number");
    case ConfigType::kLength:
      return {{"anyOf", {number_schema(key, "number"), text_schema("^[-+0-9.eE]+ *(mm|cm|m)$")}}};
    case ConfigType::kMemory:
      return {{"anyOf", {number_schema(key, "number"), text_schema("^[-+0-9.eE]+ *(KiB|MiB|GiB)$")}}};
    case ConfigType::kEnum: return words;
    case ConfigType::kList: {
      const Json list = {{"type", "array"}, {"items", words}, {"minItems", 1}, {"uniqueItems", true}};
      return {{"anyOf", {words, list}}};
    }
    case ConfigType::kTopic: return text_schema("^[A-Za-z0-9/_.~-]+$");
    case ConfigType::kCamera:
    case ConfigType::kPath: return text_schema("^[^\\x00-\\x1f]+$");
    case ConfigType::kIntrinsics: return intrinsics_schema();
  }
  return {};
}

Json key_schema(const ConfigKey& key) {
  Json schema = value_schema(key);
  if (key.allows_auto) schema = {{"anyOf", {{{"const", "auto"}}, schema}}};
  schema["description"] = key.text + (key.unit.empty() ? "" : " [" + key.unit + "]");
  const ConfigValue fallback = key.get(built_in_config());
  schema["default"] =
      key.allows_auto && std::holds_alternative<std::monostate>(fallback) ? Json("auto") : value_json(fallback);
  return schema;
}

/// `text` as an item of a list, in lines of at most 140 characters.
std::string list_item(const std::string& text) {
  constexpr std::size_t kWidth = 138;  // without the indent
  std::string item;
  for (const std::string& line : wrap(text, kWidth)) item += (item.empty() ? "- " : "  ") + line + "\n";
  return item;
}

/// "- **`fusion.voxel_size`** (0.0002..0.1 m; default 4 mm): what it does".
std::string key_markdown(const ConfigKey& key, const ScanConfig& run_defaults) {
  const std::string built_in = value_text(key, key.get(built_in_config()));
  const std::string run = value_text(key, key.get(run_defaults));
  const std::string of_run = run == built_in ? "" : fmt::format(", for `run` {}", run);
  return list_item(
      fmt::format("**`{}`** ({}; default {}{}): {}", key.name, allowed_text(key), built_in, of_run, key.text));
}

std::string sensors_markdown() {
  std::string page =
      "\n## Sensors\n\n"
      "What `acquire.sensor` stands for; values that are given win. A recording's own camera wins over a data "
      "set's.\n\n";
  for (const SensorProfile& sensor : kSensorProfiles) {
    const NoiseModel& noise = sensor.noise;
    page += list_item(fmt::format(
        "**`{}`**: {}. Range: {} to {}. Noise: floor {}, growth {} 1/m, from {}. Readout: {} s; colour {} s later.{}",
        sensor.name, sensor.what, format_length(sensor.min_depth_m), format_length(sensor.max_depth_m),
        format_length(noise.floor_m), format_number(noise.growth_per_m), format_length(noise.from_m),
        sensor.timing.readout_s, sensor.timing.colour_later_s,
        sensor.camera ? fmt::format(" Camera: {}", camera_text(*sensor.camera)) : ""));
  }
  return page;
}

}  // namespace

std::string config_to_yaml(const ScanConfig& config) {
  constexpr std::size_t kWidth = 110;
  std::string yaml;
  std::vector<std::string> open;  // the sections of the next line
  for (const ConfigKey& key : config_schema()) {
    const auto parts = split_name(key.name);
    for (std::size_t level = 0; level + 1 < parts.size(); ++level) {
      if (level < open.size() && open[level] == parts[level]) continue;
      open.resize(level);
      open.push_back(parts[level]);
      yaml += fmt::format("{}{:{}}{}:\n", level == 0 && !yaml.empty() ? "\n" : "", "", 2 * level, parts[level]);
    }
    open.resize(parts.size() - 1);
    const std::string indent(2 * (parts.size() - 1), ' ');
    for (const std::string& line : wrap(key.text, kWidth)) yaml += fmt::format("{}# {}\n", indent, line);
    yaml += fmt::format("{}{}: {}  # {}\n", indent, parts.back(), value_text(key, key.get(config)), allowed_text(key));
  }
  return yaml;
}

std::string config_to_json(const ScanConfig& config) {
  Json json = Json::object();
  for (const ConfigKey& key : config_schema()) {
    Json* place = &json;
    for (const std::string& part : split_name(key.name)) place = &(*place)[part];
    *place = value_json(key.get(config));
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace);  // names of files need not be UTF-8
}

std::string config_json_schema() {
  const auto section = [] { return Json{{"type", "object"}, {"additionalProperties", false}}; };
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "ScanKnit configuration"}};
  schema.update(section());
  for (const ConfigKey& key : config_schema()) {
    Json* place = &schema;
    const auto parts = split_name(key.name);
    for (std::size_t level = 0; level < parts.size(); ++level) {
      Json& child = (*place)["properties"][parts[level]];
      if (child.is_null()) child = level + 1 == parts.size() ? key_schema(key) : section();
      place = &child;
    }
  }
  return schema.dump(2) + "\n";
}

std::string config_markdown(const ScanConfig& run_defaults) {
  std::string page =
      "# Configuration\n\n"
      "Written by `scanknit config docs` from the table in `app/config/config_schema.cpp`; a test keeps it up to "
      "date.\n\n"
      "Values come from, each overriding the one before: the built-in value, `configs/default.yaml` (for `run` only),\n"
      "every `--preset NAME`, `--config FILE`, every `--set key=value`. Lengths are metres or carry a unit (`2mm`,\n"
      "`0.4 cm`, `3 m`), memory is MiB or carries one (`512MiB`, `2GiB`). Unknown and repeated keys, anchors and "
      "aliases\n"
      "are errors; all errors are reported in one go. `scanknit config print` writes a file to begin with,\n"
      "`scanknit config check FILE` checks one, `scanknit config schema` writes a JSON Schema for editors.\n"
      "\n"
      "The brackets beside a key hold its values, its default, and the value that `run` begins with if that is "
      "another.\n";
  std::string section;
  for (const ConfigKey& key : config_schema()) {
    const std::string current = split_name(key.name).front();
    if (current != section) {
      section = current;
      page += fmt::format("\n## {}\n\n", section);
    }
    page += key_markdown(key, run_defaults);
  }
  return page + sensors_markdown();
}

}  // namespace scanknit
