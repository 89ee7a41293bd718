// StampedPose: where a camera was at one moment. A trajectory is a vector of them.
#pragma once

#include "core/pose.h"

namespace scanknit {

struct StampedPose {
  double stamp;  ///< seconds of the recording's clock, or the frame's number where it has none
  Pose T_world_camera;
};

}  // namespace scanknit
