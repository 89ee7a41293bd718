#include "scan/refine/loop_refiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "fusion/register/motion_vector.h"
#include "scan/refine/track_alone.h"

namespace scanknit {
namespace {

constexpr double kWorthFusing = 0.1;  // voxels: poses that change less than this are not worth fusing all frames again

double farthest_moved_m(const Trajectory& from, const Trajectory& to) {
  double farthest_m = 0;
  for (std::size_t i = 0; i < to.size(); ++i) {
    const Eigen::Vector3d moved = to[i].T_world_camera.translation() - from[i].T_world_camera.translation();
    farthest_m = std::max(farthest_m, moved.norm());
  }
  return farthest_m;
}

/// How far apart two poses are; a turn counts as the motion of what is a metre away.
double apart(const PosedFrame& a, const PosedFrame& b) {
  const Pose motion = a.T_world_camera.inverse() * b.T_world_camera;
  return motion.translation().norm() + angle_of(motion);
}

/// The camera's motion during a frame; none if the walk does not have the frame.
FrameMotion motion_during(std::uint64_t sequence, const Trajectory& walk) {
  const auto at = std::find_if(walk.begin(), walk.end(), [&](const PosedFrame& f) { return f.sequence == sequence; });
  return at == walk.end() ? FrameMotion() : at->motion;
}

}  // namespace

LoopRefiner::LoopRefiner(const ScanConfig& config, const FrameArchive& archive, ScanSession& session)
    : config_(config), archive_(archive), session_(session), keys_(config.fusion.noise) {}

void LoopRefiner::note_fused(const Frame& frame, const Pose& T_world_camera, bool follows_gap) {
  fused_.push_back(frame.sequence);
  colour_is_timely_ = searches_colour_time(config_.acquire.timing(), frame);
  session_.timed("key_frames", [&] { keys_.add(frame, T_world_camera, follows_gap); });
}

void LoopRefiner::start_over() {
  keys_ = KeyFrames(config_.fusion.noise);
  fused_.clear();
  runs_.clear();
  recovered_.clear();
}

/// Lost frames may fit the frames beside them, but not what else the scan holds there, as where a walk that has drifted
/// meets its own beginning. Tracked apart from it, they are key frames from which loops lead on.
Result<void> LoopRefiner::track_lost_runs(const TrackedWalk& walk) {
  if (!archive_.is_kept()) return {};
  const std::vector<LostRun> runs = lost_runs(walk);
  if (runs.empty()) return {};
  session_.info("frames that were lost are tracked apart from the scan, from both sides");
  if (auto made = walk.make_room(); !made) return made;
  LostRunTracker tracker(config_, archive_, keys_, session_.stop());
  for (const LostRun& run : runs) {
    auto found = session_.timed("loops", [&] { return tracker.track(run); });
    if (!found) return found.error();
    if (found->size() > 0) note_run(run, *std::move(found));
  }
  return {};
}

/// Puts the frames of a run among those that were noted.
void LoopRefiner::note_run(const LostRun& run, FoundRun found) {
  const auto before = run.before.empty() ? std::nullopt : std::optional(run.before.back().sequence);
  const auto after = run.after.empty() ? std::nullopt : std::optional(run.after.front().sequence);
  const bool is_held = found.T_before_after && found.is_held_by(run.T_world_before(), run.T_world_after());
  const auto at = std::lower_bound(fused_.begin(), fused_.end(), run.lost.front());
  const auto first = static_cast<std::size_t>(at - fused_.begin());
  const bool has_gap = keys_.follows_gap(first) && !is_held;
  insert(first, found.from_before, {.before = false, .after = has_gap});
  insert(first + found.from_before.frames.size(), found.from_after, {.before = !is_held, .after = false});
  runs_.push_back({before, after, first, std::move(found)});
}

void LoopRefiner::insert(std::size_t at, FoundSide& side, const KeyFrames::Gaps& gaps) {
  std::vector<std::uint64_t> sequences;
  std::vector<Pose> T_world_frames;
  for (const FoundFrame& frame : side.frames) {
    sequences.push_back(frame.posed.sequence);
    T_world_frames.push_back(frame.posed.T_world_camera);
  }
  fused_.insert(fused_.begin() + static_cast<std::ptrdiff_t>(at), sequences.begin(), sequences.end());
  keys_.insert(at, std::move(side.keys), T_world_frames, gaps);
}

LoopClosure LoopRefiner::find_loops() {
  const double tolerance_m = kWorthFusing * config_.fusion.voxel_size_m;
  return session_.timed("loops",
                        [&] { return close_loops(keys_, config_.fusion.noise, tolerance_m, colour_is_timely_); });
}

LoopResult LoopRefiner::described(const LoopClosure& closure) const {
  LoopResult loops{closure.is_corrected, closure.drift_m, 0, {}};
  for (const Loop& loop : closure.loops) {
    loops.pairs.push_back(
        {fused_[loop.from], fused_[loop.to], loop.shift_m, loop.overlap, loop.inlier_share, loop.refused});
  }
  return loops;
}

Result<std::optional<Trajectory>> LoopRefiner::refine(const TrackedWalk& walk) {
  if (session_.is_stopped()) return std::optional<Trajectory>();
  if (auto tracked = track_lost_runs(walk); !tracked) warn_not_found(tracked.error());
  LoopClosure closure = find_loops();
  result_ = described(closure);
  auto closed = close(walk, std::move(closure));
  keys_ = KeyFrames(config_.fusion.noise);  // a few megabytes each, and of no use any more
  if (closed) return closed;
  warn_not_closed(closed.error());
  return std::optional<Trajectory>();
}

/// Tracks the frames of each range again, in a volume that holds nothing but them, and moves the rest of the walk along
/// with them. If tracking is lost, the frames after it keep their motion relative to each other.
Result<void> LoopRefiner::track_again(const std::vector<FrameRange>& ranges, const TrackedWalk& walk) {
  if (auto made = walk.make_room(); !made) return made;
  const auto source = archive_.open();
  if (!source) return source.error();
  for (const FrameRange& frames : ranges) {
    const auto sequences = std::span(fused_).subspan(frames.first, frames.last - frames.first + 1);
    const auto poses = session_.timed("loops", [&] {
      return track_alone(**source, sequences, motion_during(sequences.front(), walk.trajectory), config_,
                         session_.stop());
    });
    if (!poses) return poses.error();
    keys_.replace(frames.first, *poses);
  }
  return {};
}

bool LoopRefiner::is_of_lost_run(std::size_t noted) const {
  return std::any_of(runs_.begin(), runs_.end(),
                     [&](const NotedRun& run) { return noted >= run.first && noted < run.first + run.found.size(); });
}

/// The frames of the run that loops join to frames that were not lost: those from before up to the last joined one,
/// those from after from the first joined one on.
LoopRefiner::JoinedFrames LoopRefiner::joined_by_loops(const NotedRun& run, const LoopClosure& closure) const {
  JoinedFrames joined{0, run.found.size()};
  const std::size_t from_before = run.found.from_before.frames.size();
  const auto join = [&](std::size_t frame, std::size_t other) {
    if (frame < run.first || frame >= run.first + run.found.size() || is_of_lost_run(other)) return;
    const std::size_t number = frame - run.first;
    if (number < from_before) {
      joined.up_to = std::max(joined.up_to, number + 1);
    } else {
      joined.from = std::min(joined.from, number);
    }
  };
  for (const Loop& loop : closure.loops) {
    if (!loop.refused.empty()) continue;
    join(loop.from, loop.to);
    join(loop.to, loop.from);
  }
  return joined;
}

/// The trajectory with those frames of lost runs that are joined to the rest: by both sides, which agree, or by loops.
/// Notes them in recovered_. `known`: the poses of the trajectory as corrected.
Trajectory LoopRefiner::with_joined_runs(Trajectory trajectory, const PosesBySequence& known,
                                         const LoopClosure& closure) {
  recovered_.clear();
  for (const NotedRun& run : runs_) {
    const bool is_held = run.before && run.after && run.found.is_held_by(known.at(*run.before), known.at(*run.after));
    const JoinedFrames joined = is_held ? JoinedFrames{run.found.size(), 0} : joined_by_loops(run, closure);
    std::size_t number = 0;
    for (const FoundSide* side : {&run.found.from_before, &run.found.from_after}) {
      for (const FoundFrame& frame : side->frames) {
        const bool is_joined = number < joined.up_to || number >= joined.from;
        ++number;
        if (!is_joined) continue;
        trajectory.push_back(frame.posed);
        recovered_.push_back(frame.tracked);
        recovered_.back().reason = is_held ? TrackReason::kFoundFromBothSides : TrackReason::kFoundByLoop;
      }
    }
  }
  std::sort(trajectory.begin(), trajectory.end(),
            [](const PosedFrame& a, const PosedFrame& b) { return a.sequence < b.sequence; });
  return trajectory;
}

/// The trajectory with the corrected poses of the frames that were noted. A frame that was found later moves along with
/// the noted frame before or after it, whichever is nearer: across a gap, their corrections may differ.
Trajectory LoopRefiner::moved(const Trajectory& trajectory, const std::vector<Pose>& T_world_noted) const {
  struct Noted {
    std::size_t in_trajectory, in_fused;
  };
  std::vector<Noted> noted;
  for (std::size_t i = 0, k = 0; i < trajectory.size(); ++i) {
    while (k < fused_.size() && fused_[k] < trajectory[i].sequence) ++k;
    if (k < fused_.size() && fused_[k] == trajectory[i].sequence) noted.push_back({i, k});
  }
  Trajectory corrected = trajectory;
  if (noted.empty()) return corrected;
  std::size_t next = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    while (next < noted.size() && noted[next].in_trajectory < i) ++next;
    if (next < noted.size() && noted[next].in_trajectory == i) {
      corrected[i].T_world_camera = T_world_noted[noted[next].in_fused];
      continue;
    }
    const auto apart_m = [&](std::size_t k) { return apart(trajectory[i], trajectory[noted[k].in_trajectory]); };
    const bool is_after = next < noted.size() && (next == 0 || apart_m(next) <= apart_m(next - 1));
    const auto [in_trajectory, in_fused] = noted[is_after ? next : next - 1];
    const Pose T_corrected_tracked = T_world_noted[in_fused] * trajectory[in_trajectory].T_world_camera.inverse();
    corrected[i].T_world_camera = T_corrected_tracked * trajectory[i].T_world_camera;
  }
  return corrected;
}

Result<std::optional<Trajectory>> LoopRefiner::close(const TrackedWalk& walk, LoopClosure closure) {
  if (closure.has_loops() && !closure.mistracked.empty() && archive_.is_kept()) {
    session_.info("frames were wrongly aligned with older parts of the scan: they are tracked again");
    if (const auto tracked = track_again(closure.mistracked, walk); !tracked) return tracked.error();
    closure = find_loops();
  }
  result_ = described(closure);
  result_->is_corrected = false;  // it is corrected only when the frames have been fused again
  is_corrected_ = closure.is_corrected;
  if (is_corrected_) {
    session_.info(fmt::format("the camera came back to a known place with a drift of {:.0f} mm: closing the loop",
                              closure.drift_m * 1000));
    if (!archive_.is_kept()) {
      return Error{ErrorCode::kInput, "closing it needs the frames again, and no recording was made"};
    }
  }
  const auto corrected = [&](const Trajectory& walked) {
    return is_corrected_ ? moved(walked, closure.T_world_cameras) : walked;
  };
  const Trajectory walked = with_joined_runs(walk.trajectory, poses_of(corrected(walk.trajectory)), closure);
  if (!is_corrected_ && recovered_.empty()) return std::optional<Trajectory>();
  Trajectory better = corrected(walked);
  largest_correction_m_ = farthest_moved_m(walked, better);
  wanted_ = better.size();
  return std::optional(std::move(better));
}

Result<void> LoopRefiner::accept(TsdfVolume& /*volume*/) {
  result_->is_corrected = is_corrected_;
  result_->largest_correction_m = largest_correction_m_;
  return {};
}

Result<void> LoopRefiner::reject(const Result<std::size_t>& fused) {
  recovered_.clear();
  const Error error =
      fused ? Error{ErrorCode::kInput, fmt::format("only {} of {} frames could be read again", *fused, wanted_)}
            : fused.error();
  if (is_corrected_) {
    warn_not_closed(error);
  } else {
    warn_not_found(error);
  }
  return {};
}

void LoopRefiner::warn_not_found(const Error& error) {
  session_.warn(WarningCode::kLostNotSearched, "frames that were lost could not be looked for again: " + error.text());
}

void LoopRefiner::warn_not_closed(const Error& error) {
  session_.warn(WarningCode::kLoopNotClosed,
                session_.is_stopped() ? "closing the loop was interrupted: the mesh is as tracked"
                                      : "the loop could not be closed, the mesh is as tracked: " + error.text());
}

std::unique_ptr<PoseRefiner> loop_refiner(const ScanConfig& config, PoseMode poses, const FrameArchive& archive,
                                          ScanSession& session) {
  if (poses != PoseMode::kTrack || !config.fusion.loop_closure) return std::make_unique<NoRefiner>();
  return std::make_unique<LoopRefiner>(config, archive, session);
}

}  // namespace scanknit
