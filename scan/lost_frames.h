// LostFrames: looks again for the poses of frames that were lost, when all frames of a scan have been tracked.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "fusion/track/tracker.h"

namespace scanknit {

/// Gets all frames of a scan in their order. It follows the camera into a gap from the frame before the gap, then
/// backwards from the frame after it; in between it recognises places that were scanned before or since.
class LostFrames {
 public:
  struct Calls {
    /// Filters the frame and finds its pose: Tracker::track_later().
    std::function<Result<TrackResult>(Frame& frame, const std::optional<KnownFrame>& neighbour)> track;
    /// Fuses the filtered frame at the pose that was found.
    std::function<Result<void>(Frame& frame, const TrackResult& found)> fuse;
  };
  explicit LostFrames(Calls calls) : calls_(std::move(calls)) {}

  /// A frame that was fused. Errors: those of the calls.
  [[nodiscard]] Result<void> add_known_frame(const KnownFrame& frame);
  /// A frame that was lost, as it was read. Errors: those of the calls.
  [[nodiscard]] Result<void> add_lost_frame(const Frame& frame);

 private:
  struct Found {
    Frame frame;  ///< filtered
    TrackResult result;
  };
  [[nodiscard]] Result<std::optional<Found>> find(const Frame& frame, const std::optional<KnownFrame>& neighbour);
  [[nodiscard]] Result<bool> track_forward(const Frame& frame);
  [[nodiscard]] Result<void> relocalise(const Frame& frame);
  [[nodiscard]] Result<void> track_backward_from(KnownFrame frame);

  Calls calls_;
  std::optional<KnownFrame> before_;  ///< from which to go on
  int misses_ = 0;                    ///< frames in a row that did not fit there
  std::deque<Frame> waiting_;         ///< the last frames of this gap that have no pose, as they were read
  std::vector<Found> recognised_;     ///< a place that was recognised must hold for some frames in a row
};

}  // namespace scanknit
