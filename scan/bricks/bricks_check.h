// Whether a scan can be fused in bricks.
#pragma once

#include "acquire/acquire_config.h"
#include "core/result.h"
#include "scan/scan_job.h"

namespace scanknit {

/// Errors (kUsage): the first thing that the job asks for and that needs the whole volume in memory. `poses`: of the
/// open recording.
[[nodiscard]] Result<void> check_bricks(const ScanJob& job, PoseMode poses);

/// The same where the mesh may be made of voxels of twice the size if it is closed: holes can be closed then.
[[nodiscard]] Result<void> check_coarse_bricks(const ScanJob& job, PoseMode poses);

}  // namespace scanknit
