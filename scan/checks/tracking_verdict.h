// Whether tracking held well enough to make a mesh of what was fused.
#pragma once

#include <optional>
#include <string>

#include "core/result.h"
#include "scan/scan_result.h"

namespace scanknit {

/// How tracking went over a whole scan.
struct TrackedScan {
  const std::optional<TrackingResult>& tracking;
  const FrameCounts& frames;
  bool is_budget_reached = false;
};

/// An error when poses were tracked, and tracking was lost in more than half of the frames; its message counts the
/// reasons. kBudget: the volume had reached fusion.memory_budget, which may be the cause; the volume can be meshed.
/// kTooLittle: the camera was not found again.
[[nodiscard]] Result<void> check_tracking(const TrackedScan& scan);

/// The text of a warning when tracking was lost in more than a tenth of the frames, and there is a mesh.
[[nodiscard]] std::optional<std::string> tracking_warning(const TrackedScan& scan);

}  // namespace scanknit
