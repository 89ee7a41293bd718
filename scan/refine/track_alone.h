// Tracks a part of a recording again, in a volume that holds nothing but that part.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "acquire/frame_source.h"
#include "core/frame.h"
#include "core/frame_timing.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/track/tracker.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_config.h"

namespace scanknit {

/// Tracks frames in a volume of its own. Frames come in their order, or all in reverse order.
class LoneTracker {
 public:
  /// `config` outlives it. `first`: the camera's motion during the first frame, which its own tracking cannot know.
  /// Errors: TsdfVolume::create().
  [[nodiscard]] static Result<LoneTracker> create(const ScanConfig& config, const FrameMotion& first);

  /// Filters the frame, finds its pose in the axes of the first one, and fuses it unless it is lost: then `frame` is as
  /// it was fused. Errors: those of filter_frame() and integrate().
  [[nodiscard]] Result<TrackResult> add(Frame& frame);

 private:
  LoneTracker(const ScanConfig& config, const FrameMotion& first, TsdfVolume volume)
      : config_(&config), first_(first), volume_(std::move(volume)), tracker_({.timing = config.acquire.timing()}) {}

  const ScanConfig* config_;
  std::optional<FrameMotion> first_;  ///< until the first frame has come
  TsdfVolume volume_;
  Tracker tracker_;
};

/// The poses of the frames with these sequence numbers, in the axes of the first. Ends at the frame at which tracking
/// is lost. `first`: the camera's motion during the first. Errors: those of the source and of integrate(); kInput when
/// a frame is missing.
[[nodiscard]] Result<std::vector<Pose>> track_alone(FrameSource& source, std::span<const std::uint64_t> sequences,
                                                    const FrameMotion& first, const ScanConfig& config,
                                                    const std::stop_token& stop);

}  // namespace scanknit
