#include "scan/checks/settings_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/masks/found_masks.h"
#include "export/mesh/write_mesh.h"

namespace scanknit {
namespace {

using Keys = std::vector<std::string>;

constexpr const char* kMaxHole = "finish.max_hole";

/// "a", "a and b", "a, b and c".
std::string list_text(const Keys& keys) {
  std::string text;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0) text += i + 1 == keys.size() ? " and " : ", ";
    text += keys[i];
  }
  return text;
}

/// The keys of `export:` that are on, or asked for, and change only GLB files, or those and the GLB of tiles.
Keys glb_keys(const ScanJob& job, bool has_tiles) {
  const ExportConfig& config = job.config.output;
  Keys keys;
  if (config.quantize) keys.emplace_back("export.quantize");
  if (config.compress && !has_tiles) keys.emplace_back("export.compress");
  if (job.asks_for("export.material") && !has_tiles) keys.emplace_back("export.material");
  if (config.texture != TextureFormat::kOff) keys.emplace_back("export.texture");
  return keys;
}

/// The keys of `finish:` that are on, or asked for, and change only what finish.watertight closes.
Keys hole_keys(const ScanJob& job) {
  Keys keys;
  if (job.asks_for(kMaxHole)) keys.emplace_back(kMaxHole);
  if (job.config.finish.invented_colour) keys.emplace_back("finish.mark_invented");
  return keys;
}

void warn_of_settings_without_effect(const ScanJob& job, ScanSession& session) {
  const auto warn_of = [&](const Keys& keys, std::string_view why) {
    if (keys.empty()) return;
    const char* verb = keys.size() == 1 ? "has" : "have";
    session.warn(WarningCode::kNoEffect, fmt::format("{} {} no effect because {}", list_text(keys), verb, why));
  };
  const ScanConfig& config = job.config;
  const FinishConfig& finish = config.finish;
  const auto& meshes = job.files.meshes;
  const bool has_tiles = std::any_of(meshes.begin(), meshes.end(), is_tiles_path);
  if (std::none_of(meshes.begin(), meshes.end(), is_glb_path)) {
    warn_of(glb_keys(job, has_tiles), "no GLB file is written");
  }
  if (!has_tiles && config.output.georeference.longitude_deg) {
    warn_of({"export.georeference"}, "no tiles are written");
  }
  if (finish.ground == GroundMode::kKeep && finish.ground_clearance_m) {
    warn_of({"finish.ground_clearance"}, "finish.ground is keep");
  }
  if (config.acquire.geometry == Geometry::kSilhouettes && config.fusion.silhouettes == SilhouetteUse::kCarve) {
    warn_of({"fusion.silhouettes"}, "acquire.geometry is silhouettes: there is no depth");
  }
  if (finish.watertight == Watertight::kOff) warn_of(hole_keys(job), "finish.watertight is off");
  if (finish.watertight == Watertight::kFull && job.asks_for(kMaxHole)) {
    warn_of({kMaxHole}, "finish.watertight: full closes every hole");
  }
}

}  // namespace

void warn_of_settings(const ScanJob& job, ScanSession& session) {
  warn_of_settings_without_effect(job, session);
  if (job.config.extract.decider != Decider::kLorensen) return;
  session.warn(WarningCode::kMeshHasHoles,
               "extract.decider: lorensen leaves holes in the mesh; it is for teaching only (trilinear leaves none)");
}

Result<void> check_carving(const ScanConfig& config) {
  if (config.fusion.silhouettes != SilhouetteUse::kCarve) return {};
  if (mask_origin(config.acquire) != MaskOrigin::kNone) return {};
  return Error{ErrorCode::kConfig,
               "carve needs masks: set acquire.masks to their folder, or to alpha if the colour pictures have it, or "
               "acquire.background to a picture without the thing",
               "fusion.silhouettes"};
}

}  // namespace scanknit
