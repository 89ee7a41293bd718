// What a scan leaves beside its meshes: the volume and the trajectory.
#pragma once

#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Writes those of the two that the job asks for, the volume first, and names them in `files`; `view_sigma_m`: see
/// TsdfVolume::save(). Errors: kOutput.
[[nodiscard]] Result<void> write_beside_mesh(const TsdfVolume& volume, const Trajectory& trajectory, const ScanJob& job,
                                             ScanSession& session, FilesByKind& files,
                                             std::optional<double> view_sigma_m = std::nullopt);

}  // namespace scanknit
