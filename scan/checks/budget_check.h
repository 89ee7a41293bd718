// Checks, before the first frame is fused, whether the volume will fit into memory.
#pragma once

#include <stop_token>

#include "core/result.h"
#include "scan/scan_job.h"

namespace scanknit {

/// False if about twenty frames of the job's recording, evenly spread, need more than fusion.memory_budget; see
/// check_budget().
[[nodiscard]] bool fits_into_budget(const ScanJob& job, std::stop_token stop);

/// Reads about twenty frames of the job's recording, evenly spread, and counts the blocks that they need. Errors
/// (kBudget) when these exceed fusion.memory_budget; the message names a voxel size that would fit, at most about a
/// fifth coarser than the finest, and says when it was found from some of the frames only. For the frames that it
/// reads, it never passes a volume that is too large; below 1 cm it may refuse one that needs four fifths of the
/// budget. A long recording, of which it reads few frames, can still reach the budget later. Recordings that cannot be
/// read pass: fusing them gives the error. Recordings whose poses must be tracked pass too: their extent is not known
/// yet.
[[nodiscard]] Result<void> check_budget(const ScanJob& job, PoseMode poses, std::stop_token stop);

}  // namespace scanknit
