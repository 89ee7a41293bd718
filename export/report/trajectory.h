// A trajectory as text, in the TUM format.
#pragma once

#include <string>
#include <vector>

#include "core/trajectory.h"

namespace scanknit {

/// TUM format: "stamp tx ty tz qx qy qz qw", one line a pose, with enough digits to restore the pose within 1e-9.
[[nodiscard]] std::string to_tum_trajectory(const std::vector<StampedPose>& poses);

}  // namespace scanknit
