// A trajectory's file, in the TUM format.
#pragma once

#include <string>
#include <vector>

#include "core/pose.h"

namespace scanknit {

/// Where a camera was at one moment.
struct StampedPose {
  double stamp;  ///< seconds of the recording's clock, or the frame's number where it has none
  Pose T_world_camera;
};

/// TUM format: "stamp tx ty tz qx qy qz qw", one line a pose, with enough digits to restore the pose within 1e-9.
[[nodiscard]] std::string to_tum_trajectory(const std::vector<StampedPose>& poses);

}  // namespace scanknit
