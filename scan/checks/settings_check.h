// Warns of settings that a job's files show badly or not at all.
#pragma once

#include "scan/scan_job.h"
#include "scan/scan_session.h"

namespace scanknit {

/// To be called before the work: warns of each setting that changes none of the job's files, and of a decider whose
/// meshes have holes by design.
void warn_of_settings(const ScanJob& job, ScanSession& session);

/// Errors: kConfig when fusion.silhouettes is carve and the frames have no masks.
[[nodiscard]] Result<void> check_carving(const ScanConfig& config);

}  // namespace scanknit
