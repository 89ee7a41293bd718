// plan_parts: the first step of a scan in bricks.
#pragma once

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/frames/depth_samples.h"
#include "scan/scan_job.h"
#include "scan/scan_pass.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Reads all frames of `input`, which have poses, and finds which part of space each of them changes; divides that
/// space into parts as fusion.bricks says, `off` as `auto`. `samples`, unless null, gets the frames. `counts`: of the
/// frames, also after an error. Errors: those of scan_walk(); kBudget for a brick of fusion.bricks that exceeds the
/// budget; kInput when a stop was requested.
[[nodiscard]] Result<PlannedScan> plan_parts(const ScanJob& job, const PassInput& input, ScanSession& session,
                                             FrameCounts& counts, DepthSamples* samples);

/// Filters a frame of the job's recording, before it is planned or fused.
[[nodiscard]] Result<void> filter(Frame& frame, const ScanConfig& config, ScanSession& session);

}  // namespace scanknit
