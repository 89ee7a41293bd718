// Loop closure: finds the places that a walk came back to, and corrects the poses.
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
  double shift_m = 0;        ///< distance of the common surface in both frames, at the tracked poses
  double overlap = 0;        ///< overlap of the two pictures
  double inlier_share = 0;   ///< share of the common points
  std::string refused = {};  ///< why the loop was rejected; empty when it was accepted
};

/// Frames from `first` to `last`, inclusive.
struct FrameRange {
  std::size_t first = 0, last = 0;
};

struct LoopClosure {
  /// Ranges in which old parts of the volume seem to have pulled the tracker: the motion between two frames, registered
  /// with each other, differs from the tracked one. This happens when a drifted walk meets a part that it saw long ago.
  /// In order.
  std::vector<FrameRange> mistracked;
  std::vector<Loop> loops;            ///< accepted and rejected loops
  std::vector<Pose> T_world_cameras;  ///< of all frames that were fused; as tracked, unless `is_corrected`
  bool is_corrected = false;          ///< the poses were corrected for drift
  double drift_m = 0;                 ///< the largest shift of all accepted loops

  [[nodiscard]] bool has_loops() const { return !loops.empty(); }
};

/// Finds pairs of key frames that show the same place although the walk between them is long, by their tracked poses
/// and by common features, and registers each pair. Accepts a loop when the motion fits in both directions, when the
/// walk can have drifted so far, and when another loop nearby agrees (a cycle of the two closes): a wrong loop is worse
/// than none. If there is one, registers key frames with their neighbours as well, and distributes the drift over the
/// walk by a pose graph (pose_graph.h); does both twice, because more places overlap after the first time. Keeps the
/// poses if no point that a key frame sees would move by more than `tolerance_m`. `colour_is_timely`: as in IcpConfig,
/// of all key frames. The same bits for any number of threads.
[[nodiscard]] LoopClosure close_loops(const KeyFrames& frames, const NoiseModel& noise, double tolerance_m,
                                      bool colour_is_timely = false);

}  // namespace scanknit
