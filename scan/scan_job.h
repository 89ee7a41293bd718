// ScanJob: what to scan, how, and which files to write.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/replay/paced_source.h"
#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

struct Rig;  // acquire/rig/rig_config.h

/// The files to write; those without a path are not made. Each is written whole or not at all.
struct ScanFiles {
  std::vector<std::filesystem::path> meshes;  ///< .glb, .ply, .obj, .stl, .3mf; .tiles is a folder
  std::optional<std::filesystem::path> preview;
  std::optional<std::filesystem::path> error, coverage;  ///< maps of the mesh; need depth frames
  std::optional<std::filesystem::path> trajectory;       ///< in the format of its ending: trajectory_text()
  std::optional<std::filesystem::path> volume;           ///< .vdb
};

struct ScanJob {
  std::filesystem::path input;  ///< a recording, a volume's file, or the name of a scanner
  /// Its recordings are scanned as one, and `input` is the first of them: acquire/rig/rig_source.h.
  std::shared_ptr<const Rig> rig = nullptr;
  ScanConfig config;
  /// Keys of the configuration that the user asks for, "finish.max_hole": the scan warns of one that has no effect.
  std::set<std::string, std::less<>> asked_keys = {};
  ScanFiles files;
  std::vector<std::filesystem::path> files_of_caller = {};  ///< the caller writes them after the scan; see
                                                            ///< check_files()
  bool measures_fit = false;       ///< compare the mesh with some of the depth frames: MeshResult::fit
  bool meshes_each_class = false;  ///< of the masks, instead of one mesh: scan_classes()
  Pace pace = Pace::kFast;
  std::function<PaceControl()> pace_control = steady_pace_control;
  std::optional<std::filesystem::path> angles = std::nullopt;  ///< of a turntable: degrees, a line for each frame
  std::optional<std::filesystem::path> cut_recording = std::nullopt;  ///< of a turntable: write its frames here

  /// True even if the asked value equals the built-in one.
  [[nodiscard]] bool asks_for(std::string_view key) const { return asked_keys.contains(key); }
};

/// Checks that every file of the job, and of the caller, can be written. Errors: kOutput.
[[nodiscard]] Result<void> check_files(const ScanJob& job);

/// The picture of export.uncertainty, beside the job's first mesh: NAME_uncertainty.png. Nothing unless it is asked
/// for, or without a mesh.
[[nodiscard]] std::optional<std::filesystem::path> uncertainty_picture(const ScanJob& job);

/// The paths of all files.
[[nodiscard]] std::vector<std::filesystem::path> all_paths(const ScanFiles& files);

}  // namespace scanknit
