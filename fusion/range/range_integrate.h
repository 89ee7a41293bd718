// Integrates a range scan into the volume, along the scanner's lines of sight.
#pragma once

#include "core/pose.h"
#include "core/result.h"
#include "fusion/integrate/integrate.h"
#include "fusion/range/range_view.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// Like integrate() for a frame, but for a scan without a pinhole camera: the same running mean. The noise does not
/// grow with the range, so the weight is cos(incidence), less within RangeSurface::kDeepest steps of the rim, where
/// beams are split; for scans from one centre also times (nearest range / range)^2. The band reaches truncation_voxels
/// voxels or truncation_sigmas times the scan's own noise. The same bits for any number of threads. Errors: kInput for
/// a pose that is not rigid, or too far away; kBudget when memory runs out.
[[nodiscard]] Result<IntegrateStats> integrate(const RangeView& view, double noise_m, const Pose& T_world_scan,
                                               TsdfVolume& volume);

}  // namespace scanknit
