// Would the volume fit into memory? Asked before the first frame is fused.
#pragma once

#include <filesystem>
#include <stop_token>

#include "app/config.h"
#include "core/result.h"

namespace scanknit {

/// Looks at about twenty frames of the recording, evenly spread, and counts the blocks they need. Errors (kBudget) when
/// that is beyond fusion.memory_budget; the message names a voxel size that would fit. Recordings that cannot be read
/// pass: fusing them tells why. The answer is a lower bound, so a long recording can still reach the budget later.
/// Poses that are yet to be tracked say nothing of the extent: such recordings pass.
[[nodiscard]] Result<void> check_budget(const std::filesystem::path& recording, PoseMode poses, const Config& config,
                                        std::stop_token stop);

}  // namespace scanknit
