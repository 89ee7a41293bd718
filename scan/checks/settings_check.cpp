#include "scan/checks/settings_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "export/mesh/write_mesh.h"

namespace scanknit {
namespace {

constexpr const char* kMaxHole = "finish.max_hole";

/// The keys of `export:` that are set and change only GLB files, when no GLB is written.
std::vector<std::string> unused_glb_keys(const ScanFiles& files, const ExportConfig& config) {
  std::vector<std::string> unused;
  if (std::any_of(files.meshes.begin(), files.meshes.end(), is_glb_path)) return unused;
  if (config.quantize) unused.emplace_back("export.quantize");
  if (config.compress) unused.emplace_back("export.compress");
  if (config.material != Material::kLit) unused.emplace_back("export.material");
  if (config.texture != TextureFormat::kOff) unused.emplace_back("export.texture");
  return unused;
}

/// True if the user asked for a size of holes. A whole configuration, as `config print` writes it, gives every key:
/// there the built-in size does not count as a wish.
bool wants_max_hole(const ScanJob& job) {
  const bool is_built_in = job.config.finish.max_hole_m == FinishConfig{}.max_hole_m;
  return job.gives(kMaxHole) && !(is_built_in && job.gives("finish.watertight"));
}

/// The keys of `finish:` that are set without effect, each with the key that it depends on.
std::vector<std::string> unused_finish_keys(const ScanJob& job) {
  const FinishConfig& config = job.config.finish;
  std::vector<std::string> unused;
  if (config.ground == GroundMode::kKeep && config.ground_clearance_m) {
    unused.emplace_back("finish.ground_clearance (finish.ground)");
  }
  if (config.watertight != Watertight::kOff) return unused;
  if (wants_max_hole(job)) unused.emplace_back("finish.max_hole (finish.watertight)");
  if (config.invented_colour) unused.emplace_back("finish.mark_invented (finish.watertight)");
  return unused;
}

}  // namespace

void warn_of_settings_without_effect(const ScanJob& job, ScanSession& session) {
  const auto warn_of = [&](const std::vector<std::string>& unused, const char* why) {
    if (!unused.empty()) session.warn(WarningCode::kNoEffect, fmt::format("{}: {}", fmt::join(unused, ", "), why));
  };
  warn_of(unused_glb_keys(job.files, job.config.output), "for GLB only, and none is written");
  warn_of(unused_finish_keys(job), "of no effect, since the key in brackets is off");
  if (job.config.finish.watertight == Watertight::kFull && wants_max_hole(job)) {
    warn_of({kMaxHole}, "of no effect with finish.watertight: full, which closes every hole");
  }
}

}  // namespace scanknit
