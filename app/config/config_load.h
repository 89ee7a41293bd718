// From the command line's wishes to a ScanConfig: built-in values < presets < file < --set.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

struct ConfigSources {
  std::vector<std::string> presets;  ///< later ones win
  std::optional<std::filesystem::path> file;
  std::vector<std::string> assignments;  ///< "key=value"; later ones win
  /// configs/default.yaml comes before the presets. What it sets does not count as given.
  bool starts_from_run_defaults = false;
};

/// `run` begins with configs/default.yaml; whatever else was asked for comes after it.
[[nodiscard]] ConfigSources with_run_defaults(ConfigSources sources);

/// A configuration, and which of its keys a preset, a file or --set gave.
struct LoadedConfig {
  ScanConfig config = {};
  std::set<std::string, std::less<>> given = {};  ///< "fusion.voxel_size"

  /// True also where the value given is the built-in one.
  [[nodiscard]] bool gives(std::string_view key) const { return given.contains(key); }
};

/// One thing that is wrong, at "file:line:column" or "--set key=value".
struct ConfigProblem {
  std::string where;
  std::string message;  ///< "fusion.voxel_size: 2 m is outside ..."
};

/// Changes what `text` (YAML) mentions, and notes it as given; keys that are at fault keep their value. `name` stands
/// in the problems' `where`; names of files in the text are relative to `folder`. Returns every problem, in the order
/// of the text.
[[nodiscard]] std::vector<ConfigProblem> apply_yaml(std::string_view text, const std::string& name,
                                                    const std::filesystem::path& folder, LoadedConfig& loaded);

/// `assignment` as --set takes it: "fusion.voxel_size=2mm". The value may be any YAML: "export.formats=[glb, stl]".
[[nodiscard]] std::vector<ConfigProblem> apply_assignment(const std::string& assignment, LoadedConfig& loaded);

/// All sources in their order, upon the built-in values. On any problem an Error (kConfig) whose text has one line a
/// problem: "file:line:column: error: message".
[[nodiscard]] Result<LoadedConfig> load_config(const ConfigSources& sources);

}  // namespace scanknit
