// Where the cameras of a rig are, and how their clocks differ, from recordings of one board that moves before them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/lens/bundle.h"
#include "calibrate/rig/board_track.h"
#include "calibrate/target/calibration_target.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// One camera and its recording.
struct RigRecording {
  std::string name = {};  ///< for messages
  CameraModel lens = {};
  bool is_lens_known = false;  ///< false: `lens` is where the estimate begins
  /// False: the views' times are the numbers of their frames, and views of one number are taken at one time.
  bool has_clock = true;
  std::vector<TimedView> views = {};  ///< in the order of their times, at least one; sharp ones
};

struct FoundCamera {
  CameraModel lens;
  Pose T_rig_camera = Pose::Identity();
  double clock_offset_s = 0;  ///< the rig's time is the camera's and this
  // Standard deviations, as the residuals tell them; 0 for the first camera. An error of the board is not in them.
  double position_deviation_m = 0, turn_deviation_rad = 0, clock_deviation_s = 0;
  std::size_t shared_moments = 0;  ///< that others see, too
  double error_px = 0;             ///< root mean square of the distances between seen and computed corners
};

struct RigCalibration {
  std::vector<FoundCamera> cameras;  ///< of the recordings, in their order
  std::size_t moments = 0;           ///< at which two cameras or more see the board
  std::size_t outlying_corners = 0;
  double error_px = 0;
};

/// Two cameras that see the board at fewer moments tell nothing of each other.
inline constexpr std::size_t kFewestShared = 8;

/// Estimates the cameras' poses and clocks, the lenses that are not known, and the board's poses together, with Huber's
/// weights; the first camera is the rig. Pictures of several cameras need not be taken at one time: the corners of each
/// are interpolated. `target` is valid. Deterministic. Errors: kInput: recordings with and without clock, clocks that
/// do not overlap and no motion that tells how they differ; kTooLittle: a camera that shares fewer than kFewestShared
/// views with the others; cameras that are moved against each other.
[[nodiscard]] Result<RigCalibration> calibrate_rig(const std::vector<RigRecording>& recordings,
                                                   const CalibrationTarget& target);

}  // namespace scanknit
