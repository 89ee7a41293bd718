// find_poses: tracks a recording, without a mesh.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

struct FoundPoses {
  ScanResult scan;                     ///< what scan_recording() would give, without volume, mesh and files
  std::vector<std::uint64_t> fused;    ///< Frame::sequence in the order in which the mesh of that scan is fused
  std::vector<std::uint64_t> samples;  ///< Frame::sequence of the frames that its mesh is compared with
};

/// Finds the poses of a recording's frames as scan_recording() does, whose outcomes it has, lost frames and loops
/// included. The job's poses are tracked (is_tracked()), its files are not heeded. If the volume reaches
/// fusion.memory_budget, that scan's mesh has less than its poses allow.
[[nodiscard]] FoundPoses find_poses(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

}  // namespace scanknit
