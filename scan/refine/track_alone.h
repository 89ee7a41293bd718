// Tracking a part of a recording again, with nothing in the volume but that part.
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "acquire/frame_source.h"
#include "core/pose.h"
#include "core/result.h"
#include "scan/scan_config.h"

namespace scanknit {

/// The poses of the frames with these sequence numbers, in the axes of the first. Shorter when tracking is lost on the
/// way. Errors: the source's; integrate()'s; kInput when a frame is not there.
[[nodiscard]] Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                                    const ScanConfig& config, const std::stop_token& stop);

}  // namespace scanknit
