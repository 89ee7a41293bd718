// Rig: several cameras that do not move against each other, and their recordings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "acquire/acquire_config.h"
#include "core/pose.h"

namespace scanknit {

struct RigCamera {
  Pose T_rig_camera = Pose::Identity();                   ///< of the camera of its frames: depth
  std::int64_t clock_offset_ns = 0;                       ///< the rig's time is the recording's and this
  std::shared_ptr<const ScannerCamera> camera = nullptr;  ///< null: as AcquireConfig::camera says, or the recording
  std::filesystem::path recording = {};
};

/// As `calibrate rig` writes it. The world of a scan is the rig's frame, that of the first camera.
struct Rig {
  std::vector<RigCamera> cameras;  ///< at least two
};

}  // namespace scanknit
