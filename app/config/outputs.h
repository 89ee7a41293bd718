// Outputs: which files a command writes, decided and checked before any work.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "export/export_config.h"
#include "scan/scan_job.h"

namespace scanknit {

struct Outputs {
  ScanFiles scan;
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> page;  ///< report.html
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

/// What a command scans, as far as its arguments say.
[[nodiscard]] ScanJob job_of(const std::filesystem::path& input, const ScanConfig& config, const Outputs& outputs);

}  // namespace scanknit
