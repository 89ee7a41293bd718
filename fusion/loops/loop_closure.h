// Loop closure: where a walk came back to, and the poses that follow from it.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/loops/key_frames.h"

namespace scanknit {

/// Two frames that were found to show the same place.
struct Loop {
  std::size_t from, to;      ///< indices among the frames that were fused
  double shift_m = 0;        ///< how far apart tracking had put what both see
  double overlap = 0;        ///< of the two pictures
  double inlier_share = 0;   ///< of the points in both
  std::string refused = {};  ///< why it was not believed; empty when it was
};

/// Frames from `first` to `last`, both included.
struct FrameRange {
  std::size_t first = 0, last = 0;
};

struct LoopClosure {
  /// Where the tracker seems to have been pulled: two frames alone say something else of the motion between them than
  /// the volume did, which happens when it comes upon what it saw long ago and the walk has drifted. In order.
  std::vector<FrameRange> pulled;
  std::vector<Loop> loops;            ///< believed or refused
  std::vector<Pose> T_world_cameras;  ///< of all frames that were fused; as tracked, unless `is_corrected`
  bool is_corrected = false;          ///< there was drift to distribute
  double drift_m = 0;                 ///< of the loops that are believed, the largest shift

  [[nodiscard]] bool has_come_back() const { return !loops.empty(); }
};

/// Looks for pairs of key frames that show the same place though the walk between them is long: by where tracking has
/// them, and by shared features. Both are registered with each other. A loop is believed when the motion fits both
/// ways, when the walk could have drifted so far, and when another loop nearby agrees (a cycle of the two closes); a
/// wrong loop is worse than none. Where one is, key frames are registered with their neighbours as well, and all of
/// it is distributed over the walk by a pose graph (pose_graph.h), twice, since more places overlap after the first
/// time. Where that moves nothing that a key frame sees by more than `tolerance_m`, the poses stay as they are. The
/// same bits for any number of threads.
[[nodiscard]] LoopClosure close_loops(const KeyFrames& frames, const NoiseModel& noise, double tolerance_m);

}  // namespace scanknit
