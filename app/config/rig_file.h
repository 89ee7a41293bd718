// RIG.yaml: the cameras of a rig, for `run --rig`.
#pragma once

#include <filesystem>

#include "acquire/rig/rig_config.h"
#include "core/result.h"

namespace scanknit {

/// The file that `calibrate rig` writes (docs/calibration.md): cameras, a list of at least two; each has T_rig_camera,
/// and may have clock_offset_ms, camera (what a CAMERA.yaml has, or its name, relative to this file), and recording,
/// which is for people: RigCamera::recording is empty. Errors: kInput: unreadable; kConfig, with line and column.
[[nodiscard]] Result<Rig> read_rig_file(const std::filesystem::path& path);

}  // namespace scanknit
