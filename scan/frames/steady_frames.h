// The frames in which the camera moved least.
#pragma once

#include <cstddef>

#include "scan/scan_result.h"

namespace scanknit {

/// Selects at most `most` (> 0) of the poses: of each few frames in a row the one in which the camera moved least,
/// because it is the sharpest.
[[nodiscard]] PosesBySequence steadiest(const PosesBySequence& T_world_camera, std::size_t most);

}  // namespace scanknit
