// Fusing frames a second time, at poses that are known better than when they first came.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <stop_token>

#include "acquire/frame_source.h"
#include "app/config/config.h"
#include "app/terminal/console.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// T_world_camera by Frame::sequence.
using PosesBySequence = std::map<std::uint64_t, Pose>;

/// Changes a frame before it is filtered and fused, for example by clearing pixels.
using FrameEdit = std::function<void(Frame&)>;

/// Reads `source` to its end and fuses each frame that has a pose in `T_world_camera` into `volume`; others are passed
/// over. Returns how many were fused; fewer after a stop request. Errors: the source's; integrate()'s.
[[nodiscard]] Result<std::size_t> fuse_again(FrameSource& source, const PosesBySequence& T_world_camera,
                                             const Config& config, TsdfVolume& volume, std::stop_token stop,
                                             Console& console, const FrameEdit& edit = {});

}  // namespace scanknit
