// RIG.yaml: what `calibrate rig` writes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/rig/calibrate_rig.h"
#include "core/pose.h"

namespace scanknit {

/// A camera of the rig, as it is written.
struct RigEntry {
  std::string recording = {};
  Pose T_rig_camera = Pose::Identity();  ///< of the camera of depth
  ScannerCamera camera = {};             ///< its colour and depth, which were measured; neither: `camera_file` has them
  std::filesystem::path camera_file = {};
};

/// Standard deviations and errors are in comments. One entry for each of `found.cameras`.
[[nodiscard]] std::string rig_text(const RigCalibration& found, const std::vector<RigEntry>& entries);

}  // namespace scanknit
