// What the depth of a board's recording adds to the cameras of a scanner.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/depth/depth_fit.h"
#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

struct MeasuredDepth {
  DepthCalibration fit;
  std::vector<std::string> unknown;  ///< messages: what the views do not determine, and why; left out of the cameras
};

/// Adds what the views determine to `cameras`, which has colour: depth_bias, colour_later_s and, where colour has a
/// view of its own, T_colour_depth; with depth_bias also the depth camera that the recording states. `acquire` is as
/// for read_board_pictures(), which gave `pictures` and `views`. Errors: kInput: open_recording()'s; kTooLittle:
/// fit_depth()'s.
[[nodiscard]] Result<MeasuredDepth> measure_depth(const std::filesystem::path& path, AcquireConfig acquire,
                                                  const BoardPictures& pictures, const std::vector<BoardView>& views,
                                                  const CameraCalibration& calibration, const CalibrationTarget& target,
                                                  const std::stop_token& stop, ScannerCamera& cameras);

}  // namespace scanknit
