// join_parts: the last step of a scan in bricks.
#pragma once

#include "core/result.h"
#include "fusion/bricks/brick_volume.h"
#include "scan/bricks/planned_scan.h"
#include "scan/frames/depth_samples.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Extracts the surface of the bricks, a few layers at a time, finishes it, and writes all files of the job but the
/// trajectory. Adds to `result`, also after an error. Errors: those of scan_walk(); kInput when a brick is damaged.
[[nodiscard]] Result<void> join_parts(const ScanJob& job, UpAxis world_up, const BrickVolume& bricks,
                                      const DepthSamples& samples, const FrameArchive& archive, ScanSession& session,
                                      ScanResult& result);

/// Writes the poses of the plan, if the job asks for them. Errors: kOutput.
[[nodiscard]] Result<void> write_trajectory(const ScanJob& job, ScanSession& session, ScanResult& result);

/// True if the job's mesh needs depth samples.
[[nodiscard]] bool needs_samples(const ScanJob& job);

}  // namespace scanknit
