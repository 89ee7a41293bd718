// CAMERA.yaml: calibrated cameras, for acquire.intrinsics.
#pragma once

#include <optional>
#include <string>

#include "acquire/acquire_config.h"
#include "calibrate/calibrate_camera.h"

namespace scanknit {

/// The two cameras of a scanner, as far as they were calibrated; at least one.
struct ScannerCameras {
  std::optional<CameraModel> colour, depth;
};

/// The text that read_intrinsics() (config_intrinsics.h) reads; standard deviations and errors are in comments.
[[nodiscard]] std::string camera_file_text(const ScannerCameras& cameras, const CameraCalibration& calibration);

}  // namespace scanknit
