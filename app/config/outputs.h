// Outputs: the files that a command writes; decided and checked before any work.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/config/config_load.h"
#include "core/result.h"
#include "export/export_config.h"
#include "scan/scan_job.h"

namespace scanknit {

struct Outputs {
  ScanFiles scan;
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> page;  ///< report.html
};

/// The outputs that the command line asks for.
struct OutputRequest {
  std::filesystem::path output = {};  ///< a folder, or one mesh file
  std::optional<std::filesystem::path> report = {}, trajectory = {}, volume = {};
  bool has_trajectory = true;  ///< false: the command has no poses
};

/// For a folder: model.* for each of config.formats, preview.png (for a scan also error.png and coverage.png),
/// report.json, report.html and trajectory.txt. For a mesh file: only that file. Files with a path of their own are
/// written there. Errors (kUsage): an extension of an unknown format, a file where a folder is needed, two outputs with
/// the same path.
[[nodiscard]] Result<Outputs> plan_outputs(const OutputRequest& request, const ExportConfig& config);

/// kConfig if a texture is wanted of a `command` that has no colour frames.
[[nodiscard]] Result<void> refuse_texture(const ScanConfig& config, const char* command);

/// Adds the GLB and the STL that the live view offers for download, next to the first mesh, unless they are outputs
/// already.
void add_downloads(Outputs& outputs);

/// The job of a command.
[[nodiscard]] ScanJob job_of(const std::filesystem::path& input, const LoadedConfig& loaded, const Outputs& outputs);

}  // namespace scanknit
