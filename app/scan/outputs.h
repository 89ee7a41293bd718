// Outputs: which files a command writes, decided and checked before any work.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "export/export_config.h"

namespace scanknit {

struct Outputs {
  std::vector<std::filesystem::path> meshes;
  std::optional<std::filesystem::path> preview;
  std::optional<std::filesystem::path> error, coverage;  ///< maps of the mesh, where there are depth frames
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> page;  ///< report.html
  std::optional<std::filesystem::path> trajectory;
  std::optional<std::filesystem::path> volume;
};

/// What the command line asked for.
struct OutputRequest {
  std::filesystem::path output = {};  ///< a folder, or one mesh file
  std::optional<std::filesystem::path> report = {}, trajectory = {}, volume = {};
  bool has_trajectory = true;  ///< false: the command knows no poses
};

/// A folder gets model.* for each of config.formats, preview.png (a scan error.png and
/// coverage.png, too), report.json, report.html and trajectory.txt; one file gets itself.
/// Explicitly named files go where they are named. Errors (kUsage): an extension that nothing writes, a file where a
/// folder should be, two outputs of one name.
[[nodiscard]] Result<Outputs> plan_outputs(const OutputRequest& request, const ExportConfig& config);

/// Adds the GLB and the STL that the live view offers for download, beside the first mesh, where they are not yet.
void add_downloads(Outputs& outputs);

/// The keys of `export:` that are set and change GLB files only, when none is written.
[[nodiscard]] std::vector<std::string> unused_glb_keys(const Outputs& outputs, const ExportConfig& config);

/// Asks for every output whether it could be written. Errors: kOutput.
[[nodiscard]] Result<void> check_outputs(const Outputs& outputs);

}  // namespace scanknit
