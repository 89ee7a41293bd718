// A recorded path, flown again in a synthetic scene.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/limits.h"
#include "core/pose.h"
#include "core/result.h"
#include "synth/path/motion.h"

namespace scanknit {

struct PathPose {
  double time_s = 0;  ///< since the first pose
  Pose T_world_camera;
};

/// Lines of "seconds tx ty tz qx qy qz qw" (TUM RGB-D, Sturm et al. 2012); `#` begins a comment. Errors (kInput) name
/// the line: not eight numbers, times that do not increase, a quaternion whose length is not 1; fewer than two poses.
[[nodiscard]] Result<std::vector<PathPose>> read_recorded_path(const std::filesystem::path& file,
                                                               const Limits& limits = {});

/// The recorded path, moved so that it begins where `begin` is: its shape is kept, its world is left. Between two poses
/// the position is on a straight line and the rotation on the shortest arc; beyond an end the camera stands still.
[[nodiscard]] Motion fly_again(std::vector<PathPose> path, const Pose& begin, double frames_per_second);

}  // namespace scanknit
