// carve_gaps: silhouettes fill what depth left of a thing.
#pragma once

#include <optional>

#include "core/result.h"
#include "fusion/silhouette/depth_gaps.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// Of a scan with fusion.silhouettes: carve, whose frames bring their masks (AcquireConfig::keeps_masks).
struct GapsToCarve {
  const ScanConfig& config;
  const Trajectory& trajectory;  ///< of the frames that are in the volume
  const FrameArchive& archive;   ///< gives them again
  DepthGaps::MayFill may_fill = {};
};

/// Carves the visual hull of up to a hundred masks, evenly spread over the scan, and fills with it the voxels within
/// that depth never decided: unknown to the volume, and not seen as free by any frame. Reads the frames twice. Voxels
/// that are known stay as they are. Nothing, with a warning, when the masks give no hull, or after a stop request: the
/// volume is as it was. Errors: those of the frames; kBudget.
[[nodiscard]] Result<std::optional<SilhouetteResult>> carve_gaps(const GapsToCarve& request, TsdfVolume& volume,
                                                                 ScanSession& session);

}  // namespace scanknit
