// Fuses frames a second time, at better poses.
#pragma once

#include <cstddef>
#include <functional>

#include "acquire/frame_source.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct FramesToFuse {
  const Trajectory& trajectory;
  /// Changes a frame before it is filtered and fused, for example clears pixels.
  std::function<void(Frame&)> edit = {};
};

/// Reads `source` and fuses each frame of the trajectory into `volume`; skips the others. Returns how many were fused;
/// fewer after a stop request. Errors: those of the source and of integrate().
[[nodiscard]] Result<std::size_t> fuse_again(FrameSource& source, const FramesToFuse& frames, const ScanConfig& config,
                                             TsdfVolume& volume, ScanSession& session);

}  // namespace scanknit
