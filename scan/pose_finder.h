// PoseFinder: the pose of each frame, from the recording or by tracking.
#pragma once

#include <optional>

#include "acquire/acquire_config.h"
#include "core/frame.h"
#include "core/pose.h"
#include "fusion/track/tracker.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// How a frame was tracked, for TrackingResult.
[[nodiscard]] TrackedFrame described(const Frame& frame, const TrackResult& tracked);

/// False where the frame showed too little to be tracked.
[[nodiscard]] bool has_seen_enough(const TrackedFrame& frame);

class PoseFinder {
 public:
  /// `mode` is not kAuto.
  PoseFinder(PoseMode mode, const FrameTiming& timing);

  struct Found {
    Pose T_world_camera;
    FrameMotion motion = {};
  };

  /// The frame's pose; nothing when tracking is lost: then the frame must not be fused. Measures the times of the
  /// stages "track" and "raycast".
  [[nodiscard]] std::optional<Found> find(const Frame& frame, const TsdfVolume& volume, ScanSession& session);

  /// Tracker::track_later().
  [[nodiscard]] TrackResult find_later(const Frame& frame, const TsdfVolume& volume,
                                       const std::optional<KnownFrame>& neighbour, ScanSession& session);
  /// Tracker::forget_views().
  void forget_views() { tracker_.forget_views(); }
  /// Notes in tracking() that the pose of a frame that was lost is known now; `found.reason` says how.
  void note_found_later(const TrackedFrame& found);

  /// How well each frame was tracked; nothing when poses are given, and before the first frame.
  [[nodiscard]] const std::optional<TrackingResult>& tracking() const { return tracking_; }

 private:
  PoseMode mode_;
  Tracker tracker_;
  std::optional<TrackingResult> tracking_;
};

}  // namespace scanknit
