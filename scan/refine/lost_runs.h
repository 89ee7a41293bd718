// Lost runs: frames that were lost in a row, tracked apart from the rest of the scan, from both sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "fusion/loops/key_frames.h"
#include "scan/frames/frame_archive.h"
#include "scan/frames/frames_again.h"
#include "scan/refine/pose_refiner.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"

namespace scanknit {

/// Frames that were lost in a row, by Frame::sequence, and known ones on both sides; in the order of the scan.
struct LostRun {
  std::vector<PosedFrame> before, after;
  std::vector<std::uint64_t> lost;

  /// Poses of the nearest known frames; only where there are any.
  [[nodiscard]] const Pose& T_world_before() const { return before.back().T_world_camera; }
  [[nodiscard]] const Pose& T_world_after() const { return after.front().T_world_camera; }
};

/// All runs of a walk in which at least one frame shows enough to be tracked; in the order of the scan.
[[nodiscard]] std::vector<LostRun> lost_runs(const TrackedWalk& walk);

/// A frame of a lost run whose pose was found.
struct FoundFrame {
  PosedFrame posed;
  TrackedFrame tracked;
};

/// Frames of a lost run that were tracked from one of its sides, in the order of the scan.
struct FoundSide {
  std::vector<FoundFrame> frames;
  KeyFrames keys;  ///< of these frames
};

struct FoundRun {
  FoundSide from_before;
  FoundSide from_after;                ///< frames that come after those of from_before
  std::optional<Pose> T_before_after;  ///< between the nearest known frames; nothing: the two sides do not meet

  [[nodiscard]] std::size_t size() const { return from_before.frames.size() + from_after.frames.size(); }
  /// Whether the two sides meet, and agree if the nearest known frames have these poses.
  [[nodiscard]] bool is_held_by(const Pose& T_world_before, const Pose& T_world_after) const;
};

/// Tracks a run's frames in a volume that holds nothing but them and the known frames on one side: from the frames
/// before it, and, unless that leads to the frames after it, back from those. A wrong part of the scan cannot disturb
/// this, and a frame that fits two parts which do not fit each other is not lost. Where both sides agree, what is left
/// between them is distributed over the frames.
class LostRunTracker {
 public:
  /// All references outlive it. The key frames of what it finds can be inserted into `keys`.
  LostRunTracker(const ScanConfig& config, const FrameArchive& archive, const KeyFrames& keys, std::stop_token stop)
      : config_(config), keys_(keys), stop_(stop), frames_(archive, std::move(stop)) {}

  /// Errors: those of the archive, its frames, and LoneTracker.
  [[nodiscard]] Result<FoundRun> track(const LostRun& run);

 private:
  [[nodiscard]] Result<void> track_forward(const LostRun& run, FoundRun& found);
  [[nodiscard]] Result<void> track_backward(const LostRun& run, FoundRun& found);

  const ScanConfig& config_;
  const KeyFrames& keys_;
  std::stop_token stop_;
  FramesAgain frames_;
};

}  // namespace scanknit
