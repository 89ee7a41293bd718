// plan_parts: the first step of a scan in bricks.
#pragma once

#include "core/axes.h"
#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/find_poses.h"
#include "scan/frames/depth_samples.h"
#include "scan/scan_job.h"
#include "scan/scan_pass.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Reads all frames of `input`, which have poses, and finds which part of space each of them changes; divides that
/// space into parts as fusion.bricks says, `off` as `auto`. `poses`: where they come from when frames are read again.
/// `samples`, unless null, gets the frames. `counts`: of the frames, also after an error. Errors: those of scan_walk();
/// kBudget for a brick of fusion.bricks that exceeds the budget; kInput when a stop was requested.
[[nodiscard]] Result<PlannedScan> plan_parts(const ScanJob& job, const PassInput& input, PoseOrigin poses,
                                             ScanSession& session, FrameCounts& counts, DepthSamples* samples);

/// The same for poses that were tracked. Reads the frames again.
[[nodiscard]] Result<PlannedScan> plan_parts(const ScanJob& job, const FoundPoses& found, UpAxis world_up,
                                             ScanSession& session);

}  // namespace scanknit
