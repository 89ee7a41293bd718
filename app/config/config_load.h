// From the command line's wishes to a ScanConfig: built-in values < presets < file < --set.
#pragma once

#include <filesystem>
#include <optional>
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
};

/// One thing that is wrong, at "file:line:column" or "--set key=value".
struct ConfigProblem {
  std::string where;
  std::string message;  ///< "fusion.voxel_size: 2 m is outside ..."
};

/// Changes what `text` (YAML) mentions; keys that are at fault keep their value. `name` stands in the problems'
/// `where`; names of files in the text are relative to `folder`. Returns every problem, in the order of the text.
[[nodiscard]] std::vector<ConfigProblem> apply_yaml(std::string_view text, const std::string& name,
                                                    const std::filesystem::path& folder, ScanConfig& config);

/// `assignment` as --set takes it: "fusion.voxel_size=2mm". The value may be any YAML: "export.formats=[glb, stl]".
[[nodiscard]] std::vector<ConfigProblem> apply_assignment(const std::string& assignment, ScanConfig& config);

/// All sources in their order, upon `config`. On any problem an Error (kConfig) whose text has one line a problem:
/// "file:line:column: error: message".
[[nodiscard]] Result<ScanConfig> load_config(const ConfigSources& sources, ScanConfig config = {});

}  // namespace scanknit
