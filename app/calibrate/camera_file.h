// CAMERA.yaml: calibrated cameras, for acquire.camera.
#pragma once

#include <string>

#include "acquire/acquire_config.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/depth/depth_fit.h"

namespace scanknit {

/// The text that read_scanner_camera() (config_camera.h) reads; standard deviations and errors are in comments.
/// `cameras` has colour or depth. `depth` is null if depth was not measured.
[[nodiscard]] std::string camera_file_text(const ScannerCamera& cameras, const CameraCalibration& calibration,
                                           const DepthCalibration* depth);

}  // namespace scanknit
