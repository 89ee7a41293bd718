// Motion: where the camera is at any moment of a recording.
#pragma once

#include <cstdint>
#include <functional>

#include "core/pose.h"
#include "synth/path/path_names.h"
#include "synth/scene/scene.h"

namespace scanknit {

/// T_world_camera at a moment, which is counted in frames: 2.5 is half-way between the third and the fourth. May be
/// asked a little before 0 and beyond the end. Smooth, and a pure function.
using Motion = std::function<Pose(double frame)>;

struct MotionConfig {
  PathKind kind = PathKind::kScene;
  int frames = 1;                 ///< at least 1: the whole path takes so long
  double frames_per_second = 30;  ///< above 0
  std::uint64_t seed = 1;         ///< of the tremor, the turns and the stops
};

/// The fastest sudden turn, radians a second: 120 degrees. Tremor and the path's own turning come on top.
inline constexpr double kFastestTurn_rad_s = 2.0943951023931953;

/// At a whole number of frames and with kScene: bit by bit the pose of camera_path().
[[nodiscard]] Motion make_motion(const CameraPath& path, const MotionConfig& config);

}  // namespace scanknit
