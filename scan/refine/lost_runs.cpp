#include "scan/refine/lost_runs.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "fusion/register/motion_vector.h"
#include "scan/pose_finder.h"
#include "scan/refine/track_alone.h"

namespace scanknit {
namespace {

// Known frames on each side: the model that the first lost frame is tracked against. Half a second at most.
constexpr std::size_t kFewestKnown = 3;
constexpr std::size_t kMostKnown = 15;

constexpr int kMostMisses = 15;  // frames in a row: half a second, in which the camera may be found again

using Sequences = std::vector<std::uint64_t>;

/// Follows the camera from known frames into a run.
class SideTracker {
 public:
  struct Empty {
    LoneTracker tracker;
    KeyFrames keys;
  };
  /// `anchor`: the last known frame before the run, in the order of tracking; `goal`: the frame at which it ends.
  SideTracker(Empty empty, const PosedFrame& anchor, std::optional<std::uint64_t> goal)
      : tracker_(std::move(empty.tracker)), keys_(std::move(empty.keys)), anchor_(anchor), goal_(goal) {}

  [[nodiscard]] Result<Reading> add(Frame& frame) {
    const bool is_anchor = frame.sequence == anchor_.sequence;
    const auto tracked = tracker_.add(frame);
    if (!tracked) return tracked.error();
    if (tracked->is_lost()) return is_anchor || ++misses_ == kMostMisses ? Reading::kStop : Reading::kContinue;
    misses_ = 0;
    if (is_anchor) T_anchor_first_ = tracked->T_world_camera.inverse();
    if (is_anchor || !T_anchor_first_) return Reading::kContinue;
    const Pose T_anchor_frame = *T_anchor_first_ * tracked->T_world_camera;
    if (frame.sequence == goal_) {
      T_anchor_goal_ = T_anchor_frame;
      return Reading::kStop;
    }
    const Pose T_world_camera = anchor_.T_world_camera * T_anchor_frame;
    keys_.add(frame, T_world_camera, /*follows_gap=*/false);
    frames_.push_back({{frame.sequence, stamp_of(frame), T_world_camera, tracked->motion}, described(frame, *tracked)});
    return Reading::kContinue;
  }

  /// In the order in which they came.
  [[nodiscard]] FoundSide found() && { return {std::move(frames_), std::move(keys_)}; }
  [[nodiscard]] const std::optional<Pose>& T_anchor_goal() const { return T_anchor_goal_; }

 private:
  LoneTracker tracker_;
  KeyFrames keys_;
  PosedFrame anchor_;
  std::optional<std::uint64_t> goal_;
  int misses_ = 0;
  std::optional<Pose> T_anchor_first_, T_anchor_goal_;
  std::vector<FoundFrame> frames_;
};

/// Adds the known frames on both sides of `run.lost`.
void add_known(const Trajectory& trajectory, LostRun& run) {
  const std::size_t most = std::clamp(run.lost.size(), kFewestKnown, kMostKnown);
  const auto is_before = [&](const PosedFrame& frame) { return frame.sequence < run.lost.front(); };
  const auto after = std::partition_point(trajectory.begin(), trajectory.end(), is_before);
  run.before.assign(after - std::min(static_cast<std::ptrdiff_t>(most), after - trajectory.begin()), after);
  run.after.assign(after, after + std::min(static_cast<std::ptrdiff_t>(most), trajectory.end() - after));
}

void append(const std::vector<PosedFrame>& frames, Sequences& sequences) {
  for (const PosedFrame& frame : frames) sequences.push_back(frame.sequence);
}

/// Moves the frames so that those near to a side keep their place to it; both sides agree. The world as the frames
/// after the run have it is "later", as those before it have it "earlier".
void distribute(const LostRun& run, FoundRun& found) {
  const Pose T_later_earlier = run.T_world_after() * (run.T_world_before() * *found.T_before_after).inverse();
  const auto all = static_cast<double>(found.size() + 1);
  std::size_t frames = 0;
  for (FoundFrame& frame : found.from_before.frames) {
    Pose& pose = frame.posed.T_world_camera;
    pose = interpolate(pose, T_later_earlier * pose, static_cast<double>(++frames) / all);
  }
  for (FoundFrame& frame : found.from_after.frames) {
    Pose& pose = frame.posed.T_world_camera;
    pose = interpolate(T_later_earlier.inverse() * pose, pose, static_cast<double>(++frames) / all);
  }
}

}  // namespace

bool FoundRun::is_held_by(const Pose& T_world_before, const Pose& T_world_after) const {
  // Half of what two loops may differ by (loop_closure.cpp): the frames are as near to a side as half a run is long.
  constexpr double kAgree_m = 0.015;
  constexpr double kAgree_rad = 0.015;
  if (!T_before_after) return false;
  const Pose apart = (T_world_before * *T_before_after).inverse() * T_world_after;
  return apart.translation().norm() <= kAgree_m && angle_of(apart) <= kAgree_rad;
}

std::vector<LostRun> lost_runs(const TrackedWalk& walk) {
  std::vector<LostRun> runs;
  if (!walk.tracking) return runs;
  LostRun run;
  bool shows_enough = false;
  const auto end_run = [&] {
    if (shows_enough) {
      add_known(walk.trajectory, run);
      runs.push_back(std::move(run));
    }
    run = {};
    shows_enough = false;
  };
  for (const TrackedFrame& frame : walk.tracking->frames) {
    if (frame.state != TrackState::kLost) {
      end_run();
      continue;
    }
    run.lost.push_back(frame.sequence);
    shows_enough |= has_seen_enough(frame);
  }
  end_run();
  return runs;
}

Result<FoundRun> LostRunTracker::track(const LostRun& run) {
  FoundRun found{{{}, keys_.without_frames()}, {{}, keys_.without_frames()}, std::nullopt};
  if (!run.before.empty()) {
    if (auto tracked = track_forward(run, found); !tracked) return tracked.error();
  }
  if (!run.after.empty() && !found.T_before_after && !stop_.stop_requested()) {
    if (auto tracked = track_backward(run, found); !tracked) return tracked.error();
  }
  const bool is_held = found.T_before_after && found.is_held_by(run.T_world_before(), run.T_world_after());
  if (is_held) distribute(run, found);
  return found;
}

/// On to the first frame after the run.
Result<void> LostRunTracker::track_forward(const LostRun& run, FoundRun& found) {
  auto tracker = LoneTracker::create(config_, run.before.front().motion);
  if (!tracker) return tracker.error();
  std::optional<std::uint64_t> goal;
  if (!run.after.empty()) goal = run.after.front().sequence;
  Sequences sequences;
  append(run.before, sequences);
  sequences.insert(sequences.end(), run.lost.begin(), run.lost.end());
  if (goal) sequences.push_back(*goal);
  SideTracker side({*std::move(tracker), keys_.without_frames()}, run.before.back(), goal);
  const auto read = frames_.for_each_of(sequences, [&](Frame& frame) { return side.add(frame); });
  if (!read) return read;
  found.T_before_after = side.T_anchor_goal();
  found.from_before = std::move(side).found();
  return {};
}

/// Back to the last frame that was found from before, else to the last one before the run.
Result<void> LostRunTracker::track_backward(const LostRun& run, FoundRun& found) {
  auto tracker = LoneTracker::create(config_, run.after.back().motion);
  if (!tracker) return tracker.error();
  Trajectory known = run.before;
  for (const FoundFrame& frame : found.from_before.frames) known.push_back(frame.posed);
  std::optional<std::uint64_t> goal;
  if (!known.empty()) goal = known.back().sequence;
  Sequences sequences;
  if (goal) sequences.push_back(*goal);
  std::copy_if(run.lost.begin(), run.lost.end(), std::back_inserter(sequences),
               [&](std::uint64_t sequence) { return !goal || sequence > *goal; });
  append(run.after, sequences);
  SideTracker side({*std::move(tracker), keys_.without_frames()}, run.after.front(), goal);
  const auto read = frames_.for_each_backwards(sequences, [&](Frame& frame) { return side.add(frame); });
  if (!read) return read;
  if (const auto& T_after_goal = side.T_anchor_goal()) {
    const Pose T_before_goal = run.T_world_before().inverse() * known.back().T_world_camera;
    found.T_before_after = T_before_goal * T_after_goal->inverse();
  }
  found.from_after = std::move(side).found();
  std::reverse(found.from_after.frames.begin(), found.from_after.frames.end());
  found.from_after.keys.reverse();
  return {};
}

}  // namespace scanknit
