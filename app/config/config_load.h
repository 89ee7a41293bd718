// Makes a ScanConfig from the command line: built-in values < presets < file < --set.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "app/config/config_schema.h"
#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

struct ConfigSources {
  std::vector<std::string> presets;  ///< later ones override earlier ones
  std::optional<std::filesystem::path> file;
  std::vector<std::string> assignments;  ///< "key=value"; later ones override earlier ones
  /// Begin with configs/default.yaml, before the presets. Its keys do not count as given.
  bool starts_from_run_defaults = false;
};

/// `run` begins with configs/default.yaml; whatever else was asked for comes after it.
[[nodiscard]] ConfigSources with_run_defaults(ConfigSources sources);

/// A configuration, and which of its keys a preset, a file or --set gave.
struct LoadedConfig {
  ScanConfig config = built_in_config();
  std::set<std::string, std::less<>> given = {};  ///< "fusion.voxel_size"
  /// Those of `given` that the user asks for. A preset, and a file that gives a whole section, as `config print` writes
  /// it, ask only for values that are not the built-in ones.
  std::set<std::string, std::less<>> asked = {};

  /// True even if the given value equals the built-in one.
  [[nodiscard]] bool gives(std::string_view key) const { return given.contains(key); }
  [[nodiscard]] bool asks_for(std::string_view key) const { return asked.contains(key); }
};

/// A problem, at "file:line:column" or "--set key=value".
struct ConfigProblem {
  std::string where;
  std::string message;  ///< "fusion.voxel_size: 2 m is outside ..."
};

/// Sets the keys in `text` (YAML), and notes them as given and asked for; keys with a problem keep their value. `name`
/// is the file's name in the problems' `where`; file names in the text are relative to `folder`. Returns all problems,
/// in the order of the text.
[[nodiscard]] std::vector<ConfigProblem> apply_yaml(std::string_view text, const std::string& name,
                                                    const std::filesystem::path& folder, LoadedConfig& loaded);

/// `assignment` as --set takes it: "fusion.voxel_size=2mm". The value may be any YAML: "export.formats=[glb, stl]".
[[nodiscard]] std::vector<ConfigProblem> apply_assignment(const std::string& assignment, LoadedConfig& loaded);

/// Applies all sources in their order to the built-in values. If there is any problem, an Error (kConfig) with one line
/// for each: "file:line:column: error: message". Budgets of memory may be `auto` (kAutomaticBudgetMib).
[[nodiscard]] Result<LoadedConfig> read_config(const ConfigSources& sources);

/// The same to work with: a share of this machine's memory (core/system/machine_memory.h) where a budget is `auto`.
[[nodiscard]] Result<LoadedConfig> load_config(const ConfigSources& sources);

}  // namespace scanknit
