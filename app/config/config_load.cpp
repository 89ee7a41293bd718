#include "app/config/config_load.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "app/config/config_intrinsics.h"
#include "app/config/config_schema.h"
#include "app/config/presets.h"
#include "app/config/suggestion.h"
#include "app/config/yaml_node.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "core/system/machine_memory.h"

namespace scanknit {
namespace {

/// All full key names, and all sections ("fusion", "fusion.noise").
std::vector<std::string> known_names() {
  std::vector<std::string> names;
  for (const ConfigKey& key : config_schema()) {
    for (std::size_t dot = key.name.find('.'); dot != std::string::npos; dot = key.name.find('.', dot + 1)) {
      const std::string section = key.name.substr(0, dot);
      if (std::find(names.begin(), names.end(), section) == names.end()) names.push_back(section);
    }
    names.push_back(key.name);
  }
  return names;
}

/// Walks a YAML tree, sets the valid keys, and notes the problems.
class ConfigReader {
 public:
  ConfigReader(std::string name, std::filesystem::path folder, LoadedConfig& loaded)
      : name_(std::move(name)), folder_(std::move(folder)), loaded_(loaded) {}

  void read_section(const YamlNode& node, const std::string& section) {
    if (node.kind == YamlNode::Kind::kNull) return;  // "fusion:" with all keys below it commented out
    if (node.kind != YamlNode::Kind::kMap) {
      const std::string what = section.empty() ? "the configuration" : section;
      return note(node, what + ": expected 'key: value' lines");
    }
    for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
      read_entry(node.children[i], node.children[i + 1], section);
    }
  }

  void read_value(const ConfigKey& key, const YamlNode& node) {
    const auto value = value_of(key, node);
    if (!value) return;
    key.set(loaded_.config, *value);
    loaded_.given.insert(key.name);
    given_.insert(key.name);
  }

  void note(const YamlNode& node, std::string message) { note(node.line, node.column, std::move(message)); }
  void note(int line, int column, std::string message) {
    problems_.push_back({fmt::format("{}:{}:{}", name_, line, column), std::move(message)});
  }

  [[nodiscard]] std::vector<ConfigProblem> take_problems() { return std::move(problems_); }

  /// The keys that were set.
  [[nodiscard]] const std::set<std::string, std::less<>>& given() const { return given_; }

 private:
  void read_entry(const YamlNode& name, const YamlNode& value, const std::string& section) {
    const std::string full = section.empty() ? name.text : section + "." + name.text;
    if (!seen_.insert(full).second) return note(name, fmt::format("duplicate key '{}'", full));
    if (const ConfigKey* key = find_config_key(full)) {
      if (value.kind == YamlNode::Kind::kNull) return note(name, full + ": expected a value");
      return read_value(*key, value);
    }
    const auto known = known_names();
    if (std::find(known.begin(), known.end(), full) != known.end()) return read_section(value, full);
    const auto near = nearest_word(full, known);
    note(name, fmt::format("unknown key '{}'{}", full, near ? fmt::format("; did you mean '{}'?", *near) : ""));
  }

  [[nodiscard]] std::optional<ConfigValue> value_of(const ConfigKey& key, const YamlNode& node) {
    const bool is_auto = key.allows_auto && node.kind == YamlNode::Kind::kScalar && node.text == "auto";
    if (key.type == ConfigType::kIntrinsics && !is_auto) return intrinsics_of(key, node);
    if (key.type == ConfigType::kCamera && !is_auto) return camera_of(key, node);
    if (key.type == ConfigType::kList && node.kind == YamlNode::Kind::kSequence) return list_of(key, node);
    return word_of(key, node);
  }

  [[nodiscard]] std::optional<ConfigValue> word_of(const ConfigKey& key, const YamlNode& node) {
    if (node.kind != YamlNode::Kind::kScalar) {
      note(node,
           fmt::format("{}: expected {}", key.name, node.kind == YamlNode::Kind::kNull ? "a value" : "one value"));
      return std::nullopt;
    }
    auto value = parse_config_word(key, node.text);
    if (value) return std::move(*value);
    note(node, fmt::format("{}: {}", key.name, value.error().message));
    return std::nullopt;
  }

  [[nodiscard]] std::optional<ConfigValue> list_of(const ConfigKey& key, const YamlNode& node) {
    std::vector<std::string> words;
    for (const YamlNode& item : node.children) {
      const auto word = word_of(key, item);
      if (!word) return std::nullopt;
      const std::string& text = std::get<std::vector<std::string>>(*word).front();
      if (std::find(words.begin(), words.end(), text) != words.end()) {
        note(item, fmt::format("{}: '{}' is there twice", key.name, text));
        return std::nullopt;
      }
      words.push_back(text);
    }
    if (words.empty()) {
      note(node, fmt::format("{}: an empty list; expected some of {}", key.name, format_config_range(key)));
      return std::nullopt;
    }
    return ConfigValue(std::move(words));
  }

  [[nodiscard]] std::optional<ConfigValue> intrinsics_of(const ConfigKey& key, const YamlNode& node) {
    const auto model = read_intrinsics(node, folder_, complaint_of(key));
    return model ? std::optional<ConfigValue>(*model) : std::nullopt;
  }

  [[nodiscard]] std::optional<ConfigValue> camera_of(const ConfigKey& key, const YamlNode& node) {
    auto camera = read_scanner_camera_file(node, folder_, complaint_of(key));
    return camera ? std::optional<ConfigValue>(std::move(camera)) : std::nullopt;
  }

  [[nodiscard]] YamlComplaint complaint_of(const ConfigKey& key) {
    return [this, &key](const YamlNode& where, const std::string& what) { note(where, key.name + ": " + what); };
  }

  std::string name_;
  std::filesystem::path folder_;
  LoadedConfig& loaded_;
  std::set<std::string> seen_;
  std::set<std::string, std::less<>> given_;
  std::vector<ConfigProblem> problems_;
};

bool is_built_in(const ConfigKey& key, const ScanConfig& config) {
  return key.get(config) == key.get(built_in_config());
}

/// Notes which of `given`, the keys of one text, the user asks for.
void note_asked(const std::set<std::string, std::less<>>& given, LoadedConfig& loaded) {
  const auto section_of = [](const std::string& key) { return key.substr(0, key.find('.')); };
  std::set<std::string> in_parts;  // sections of which a key is not given
  for (const ConfigKey& key : config_schema()) {
    if (!given.contains(key.name)) in_parts.insert(section_of(key.name));
  }
  for (const ConfigKey& key : config_schema()) {
    if (!given.contains(key.name)) continue;
    const bool says_nothing = !in_parts.contains(section_of(key.name)) && is_built_in(key, loaded.config);
    if (!says_nothing) loaded.asked.insert(key.name);
  }
}

/// Checks keys against each other.
std::vector<ConfigProblem> check_together(const ScanConfig& config) {
  std::vector<ConfigProblem> problems;
  const AcquireConfig& acquire = config.acquire;
  if (acquire.max_depth_m.value_or(0) != 0 && *acquire.max_depth_m <= acquire.min_depth_m.value_or(0)) {
    problems.push_back(
        {"configuration", "acquire.max_depth: no depth would be left; expected more than acquire.min_depth"});
  }
  const FinishConfig& finish = config.finish;
  if (finish.ground == GroundMode::kCap && finish.watertight != Watertight::kFull) {
    problems.push_back(
        {"configuration", "finish.ground: cap needs finish.watertight: full; set that too, or take remove"});
  }
  const bool needs_distances = finish.watertight != Watertight::kOff || finish.ground != GroundMode::kKeep;
  if (needs_distances && config.extract.inside == InsideSide::kHigh) {
    problems.push_back({"configuration",
                        "extract.inside: high, but finish.watertight and finish.ground need signed distances with "
                        "matter below the isovalue; leave them out, or take auto"});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& low = finish.crop.low_m[axis];
    const auto& high = finish.crop.high_m[axis];
    if (!low || !high || *low < *high) continue;
    const std::string name = {"xyz"[axis]};
    problems.push_back(
        {"configuration",
         fmt::format("finish.crop.max_{}: nothing would be left; expected more than finish.crop.min_{}", name, name)});
  }
  const Georeference& place = config.output.georeference;
  if (place.longitude_deg.has_value() != place.latitude_deg.has_value()) {
    problems.push_back(
        {"configuration", "export.georeference: longitude and latitude belong together; set both, or leave both auto"});
  }
  return problems;
}

std::vector<ConfigProblem> apply_preset(const std::string& name, LoadedConfig& loaded) {
  if (const Preset* preset = find_preset(name)) {
    const auto asked_before = loaded.asked;
    auto problems = apply_yaml(preset->text, "configs/" + name + ".yaml", "", loaded);
    std::erase_if(loaded.asked, [&](const std::string& key) {
      return !asked_before.contains(key) && is_built_in(*find_config_key(key), loaded.config);
    });
    return problems;
  }
  std::vector<std::string> names;
  for (const Preset& preset : presets()) names.emplace_back(preset.name);
  const auto near = nearest_word(name, names);
  return {{"--preset " + name, fmt::format("no such preset; known are {}{}", fmt::join(names, ", "),
                                           near ? fmt::format("; did you mean '{}'?", *near) : "")}};
}

std::vector<ConfigProblem> apply_file(const std::filesystem::path& file, LoadedConfig& loaded) {
  const auto text = read_text_file(file, Limits{}.max_config_bytes);
  if (!text) return {{file.string(), text.error().message}};
  return apply_yaml(*text, file.string(), file.parent_path(), loaded);
}

}  // namespace

std::vector<ConfigProblem> apply_yaml(std::string_view text, const std::string& name,
                                      const std::filesystem::path& folder, LoadedConfig& loaded) {
  ConfigReader reader(name, folder, loaded);
  const auto parsed = parse_yaml(text);
  if (const auto* error = std::get_if<YamlError>(&parsed)) {
    reader.note(error->line, error->column, error->message);
  } else {
    reader.read_section(std::get<YamlNode>(parsed), "");
  }
  note_asked(reader.given(), loaded);
  return reader.take_problems();
}

std::vector<ConfigProblem> apply_assignment(const std::string& assignment, LoadedConfig& loaded) {
  const std::string where = "--set " + assignment;
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) return {{where, "expected key=value, for instance fusion.voxel_size=2mm"}};
  const std::string name = assignment.substr(0, equals);
  const ConfigKey* key = find_config_key(name);
  const auto known = known_names();
  if (key == nullptr && std::find(known.begin(), known.end(), name) == known.end()) {
    const auto near = nearest_word(name, known);
    return {{where, fmt::format("unknown key '{}'{}", name, near ? fmt::format("; did you mean '{}'?", *near) : "")}};
  }
  const auto parsed = parse_yaml(std::string_view(assignment).substr(equals + 1));
  if (const auto* error = std::get_if<YamlError>(&parsed)) return {{where, name + ": " + error->message}};
  const YamlNode& value = std::get<YamlNode>(parsed);
  ConfigReader reader(where, "", loaded);
  if (key != nullptr) {
    reader.read_value(*key, value);
  } else {
    reader.read_section(value, name);
  }
  loaded.asked.insert(reader.given().begin(), reader.given().end());
  auto problems = reader.take_problems();
  for (ConfigProblem& problem : problems) problem.where = where;
  return problems;
}

ConfigSources with_run_defaults(ConfigSources sources) {
  sources.starts_from_run_defaults = true;
  return sources;
}

Result<LoadedConfig> read_config(const ConfigSources& sources) {
  LoadedConfig loaded;
  std::vector<ConfigProblem> problems;
  const auto collect = [&](std::vector<ConfigProblem> more) {
    std::move(more.begin(), more.end(), std::back_inserter(problems));
  };
  if (sources.starts_from_run_defaults) {
    collect(apply_preset("default", loaded));
    loaded.given.clear();
    loaded.asked.clear();
  }
  for (const std::string& preset : sources.presets) collect(apply_preset(preset, loaded));
  if (sources.file) collect(apply_file(*sources.file, loaded));
  for (const std::string& assignment : sources.assignments) collect(apply_assignment(assignment, loaded));
  if (problems.empty()) collect(check_together(loaded.config));
  if (problems.empty()) return loaded;

  std::string text;
  for (const ConfigProblem& problem : problems) {
    text += fmt::format("{}{}: error: {}", text.empty() ? "" : "\n", problem.where, problem.message);
  }
  return Error{ErrorCode::kConfig, std::move(text)};
}

Result<LoadedConfig> load_config(const ConfigSources& sources) {
  auto loaded = read_config(sources);
  if (!loaded) return loaded;
  std::size_t& fusion_mib = loaded->config.fusion.memory_budget_mib;
  std::int64_t& extract_mib = loaded->config.extract.memory_budget_mib;
  if (fusion_mib == kAutomaticBudgetMib) fusion_mib = default_memory_budget_mib(machine_memory_mib());
  if (extract_mib == kAutomaticBudgetMib) extract_mib = static_cast<std::int64_t>(fusion_mib);
  return loaded;
}

}  // namespace scanknit
