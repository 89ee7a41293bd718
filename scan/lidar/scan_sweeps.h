// scan_sweeps: from LiDAR sweeps with poses to a finished mesh.
#pragma once

#include <stop_token>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// What scan_recording() does with a recording of LiDAR sweeps (acquire/lidar/sweep_source.h): fuses the grid of each
/// sweep at its pose, and writes all files of the job. One sweep is in memory at a time. Unless the job asks for
/// fusion.voxel_size, voxels are as large as the points of the first sweep are apart, 0.02 to 0.1 m. Unless it asks for
/// acquire.min_depth and max_depth, returns from 1 to 50 m count. ScanResult::outcome: kOutput before any work; kInput,
/// also where no sweep has a pose; kTooLittle when stopped before anything was fused; kBudget; kMesh; kUsage for
/// options that do not apply.
[[nodiscard]] ScanResult scan_sweeps(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

}  // namespace scanknit
