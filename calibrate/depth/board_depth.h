// The depth of a board in the frames of a recording.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/depth/depth_fit.h"
#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

struct BoardDepths {
  std::vector<DepthView> views;            ///< in the order of the frames
  CameraIntrinsics camera;                 ///< of depth, straightened
  Pose T_colour_depth = Pose::Identity();  ///< as the recording says
  bool has_clock = false;                  ///< false: the views' motion is unknown
};

/// Reads the recording again. `acquire` has the cameras that were found, `lens` is that of colour; a frame belongs to
/// the view of its name (board_frame_name()). Where colour has a view of its own, depth's camera and the pose between
/// both are the recording's. Errors (kInput): open_recording()'s.
[[nodiscard]] Result<BoardDepths> read_board_depths(const std::filesystem::path& path, const AcquireConfig& acquire,
                                                    const std::vector<BoardView>& views, const CameraModel& lens,
                                                    double corner_noise_px, const CalibrationTarget& target,
                                                    const std::stop_token& stop);

}  // namespace scanknit
