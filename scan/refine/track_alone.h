// Tracks a part of a recording again, in a volume that holds nothing but that part.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "acquire/frame_source.h"
#include "core/frame.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/track/tracker.h"
#include "scan/scan_config.h"

namespace scanknit {

/// Told of each frame that was tracked, as it was fused; its pose is in the axes of the first.
using OnTrackedAlone = std::function<void(const Frame& frame, const TrackResult& tracked)>;

/// The poses of the frames with these sequence numbers, in the axes of the first. Ends at the frame at which tracking
/// is lost. Errors: those of the source and of integrate(); kInput when a frame is missing.
[[nodiscard]] Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                                    const ScanConfig& config, const std::stop_token& stop,
                                                    const OnTrackedAlone& on_tracked = {});

}  // namespace scanknit
