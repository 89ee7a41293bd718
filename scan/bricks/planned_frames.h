// The frames of a plan, read again.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/result.h"
#include "scan/bricks/planned_scan.h"
#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Gets a frame and its number.
using VisitNumbered = std::function<Result<void>(Frame& frame, std::uint32_t number)>;

/// Reads the frames of `trajectory` whose numbers (from 1) are in `runs`, and calls `visit` with them by their numbers,
/// whatever the order of the recording: the few frames that were found later are read in groups that are kept in
/// memory. False when a stop was requested before it had all. Errors: those of the recording and of `visit`; kInput
/// when the recording does not have them all.
[[nodiscard]] Result<bool> for_each_numbered(const ScanJob& job, const Trajectory& trajectory,
                                             const std::vector<FrameRun>& runs, ScanSession& session,
                                             const VisitNumbered& visit);

/// The same for the frames of a plan, as they are fused: filtered, and without the camera's motion. Errors also: kInput
/// when a frame is not the one that was planned.
[[nodiscard]] Result<bool> for_each_planned(const ScanJob& job, const PlannedScan& planned,
                                            const std::vector<FrameRun>& runs, ScanSession& session,
                                            const VisitNumbered& visit);

/// Filters a frame of the job's recording and takes the camera's motion out of it.
[[nodiscard]] Result<void> prepare(Frame& frame, const FrameMotion& motion, const ScanConfig& config,
                                   ScanSession& session);

}  // namespace scanknit
