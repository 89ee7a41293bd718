// PoseFinder: where each frame was taken, from the recording or by tracking, with its quality in the report.
#pragma once

#include <optional>
#include <string>

#include "acquire/acquire_config.h"
#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/report/report.h"
#include "fusion/track/tracker.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

class PoseFinder {
 public:
  /// kAuto must have been settled.
  explicit PoseFinder(PoseMode mode);

  /// Nothing when tracking is lost: the frame must not be fused. Stages "track" and "raycast" of the report are filled.
  [[nodiscard]] std::optional<Pose> find(const Frame& frame, const TsdfVolume& volume, RunReport& report);

 private:
  PoseMode mode_;
  Tracker tracker_;
};

/// Errors when poses were tracked, and tracking was lost in more than half of the frames; the message counts the
/// reasons. kBudget: the volume had reached fusion.memory_budget, which may be why; what there is can be meshed.
/// kTooLittle: it was not found again.
[[nodiscard]] Result<void> check_tracking(const RunReport& report);

/// What to say when it was lost in more than a tenth of the frames and there is a mesh all the same.
[[nodiscard]] std::optional<std::string> tracking_warning(const RunReport& report);

}  // namespace scanknit
