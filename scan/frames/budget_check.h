// Would the volume fit into memory? Asked before the first frame is fused.
#pragma once

#include <filesystem>
#include <stop_token>

#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

/// Looks at about twenty frames of the recording, evenly spread, and counts the blocks they need. Errors (kBudget) when
/// that is beyond fusion.memory_budget; the message names a voxel size that would fit, at most about a fifth coarser
/// than the finest, and says when it does not know all frames. Recordings that cannot be read pass: fusing them tells
/// why. Of the frames it looks at no volume is missed that is too large, and below 1 cm one may be refused that needs
/// four fifths of the budget. A long recording, of which it looks at few, can still reach the budget later.
/// Poses that are yet to be tracked say nothing of the extent: such recordings pass.
[[nodiscard]] Result<void> check_budget(const std::filesystem::path& recording, PoseMode poses,
                                        const ScanConfig& config, std::stop_token stop);

}  // namespace scanknit
