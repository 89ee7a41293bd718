#include "scan/refine/loop_refiner.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "fusion/register/motion_vector.h"
#include "scan/pose_finder.h"
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

}  // namespace

LoopRefiner::LoopRefiner(const ScanConfig& config, const FrameArchive& archive, ScanSession& session)
    : config_(config), archive_(archive), session_(session), keys_(config.fusion.noise) {}

void LoopRefiner::note_fused(const Frame& frame, const Pose& T_world_camera, bool follows_gap) {
  fused_.push_back(frame.sequence);
  session_.timed("key_frames", [&] { keys_.add(frame, T_world_camera, follows_gap); });
}

void LoopRefiner::start_over() {
  keys_ = KeyFrames(config_.fusion.noise);
  fused_.clear();
  lost_end_.clear();
  recovered_.clear();
}

/// Frames may be lost at the end because the walk has drifted and meets its own beginning. Tracks them without it, on
/// from the last frames that were fused, so that the loop is found. Frames that cannot be read again stay lost.
void LoopRefiner::track_lost_end(const TrackedWalk& walk) {
  constexpr std::size_t kBefore = 15;  // frames, half a second: the model that the first lost frame is tracked against
  if (!walk.tracking || !archive_.is_kept() || walk.trajectory.size() < kBefore) return;
  std::vector<std::uint64_t> sequences;
  for (const PosedFrame& frame : std::span(walk.trajectory).last(kBefore)) sequences.push_back(frame.sequence);
  for (const TrackedFrame& frame : walk.tracking->frames) {
    if (frame.sequence > walk.trajectory.back().sequence) sequences.push_back(frame.sequence);
  }
  if (sequences.size() == kBefore) return;
  const auto source = archive_.open();
  if (!source) return;
  session_.info("the last frames were lost: they are tracked by themselves, to find where they join the scan");
  const Pose& T_world_last = walk.trajectory.back().T_world_camera;
  Pose T_first_last = Pose::Identity();
  std::size_t tracked = 0;
  const auto note = [&](const Frame& frame, const TrackResult& found) {
    if (++tracked <= kBefore) {
      T_first_last = found.T_world_camera;
      return;
    }
    const Pose T_world_camera = T_world_last * T_first_last.inverse() * found.T_world_camera;
    note_fused(frame, T_world_camera, false);
    lost_end_.push_back(
        {{frame.sequence, stamp_of(frame), T_world_camera, found.motion}, scanknit::described(frame, found)});
  };
  (void)session_.timed("loops", [&] { return track_alone(**source, sequences, config_, session_.stop(), note); });
}

LoopClosure LoopRefiner::find_loops() {
  const double tolerance_m = kWorthFusing * config_.fusion.voxel_size_m;
  return session_.timed("loops", [&] { return close_loops(keys_, config_.fusion.noise, tolerance_m); });
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
  track_lost_end(walk);
  LoopClosure closure = find_loops();
  result_ = described(closure);
  auto closed = close(walk, std::move(closure));
  if (closed) return closed;
  warn_not_closed(closed.error());
  return std::optional<Trajectory>();
}

/// Tracks the frames of each range again, in a volume that holds nothing but them, and moves the rest of the walk along
/// with them. If tracking is lost, the frames after it keep their motion relative to each other.
Result<void> LoopRefiner::track_again(const std::vector<FrameRange>& ranges) {
  const auto source = archive_.open();
  if (!source) return source.error();
  for (const FrameRange& frames : ranges) {
    const auto sequences = std::span(fused_).subspan(frames.first, frames.last - frames.first + 1);
    const auto poses =
        session_.timed("loops", [&] { return track_alone(**source, sequences, config_, session_.stop()); });
    if (!poses) return poses.error();
    keys_.replace(frames.first, *poses);
  }
  return {};
}

/// The trajectory with the frames of the lost end up to the last one that a loop joins to the rest of the walk.
Trajectory LoopRefiner::with_joined_end(Trajectory trajectory, const LoopClosure& closure) {
  const std::size_t first = fused_.size() - lost_end_.size();
  std::size_t joined = first;
  for (const Loop& loop : closure.loops) {
    if (loop.refused.empty() && loop.from < first) joined = std::max(joined, loop.to + 1);
  }
  recovered_.clear();
  for (const LostFrame& frame : std::span(lost_end_).first(joined - first)) {
    trajectory.push_back(frame.posed);
    recovered_.push_back(frame.tracked);
  }
  return trajectory;
}

/// The trajectory with the corrected poses of the frames that were noted. A frame that was found later moves along with
/// the noted frame before or after it, whichever is nearer: across a gap, their corrections may differ.
Trajectory LoopRefiner::moved(const Trajectory& trajectory, const std::vector<Pose>& T_world_noted) const {
  std::vector<std::size_t> noted;  // indices of the trajectory
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (noted.size() < fused_.size() && fused_[noted.size()] == trajectory[i].sequence) noted.push_back(i);
  }
  Trajectory corrected = trajectory;
  if (noted.empty()) return corrected;
  std::size_t next = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    while (next < noted.size() && noted[next] < i) ++next;
    if (next < noted.size() && noted[next] == i) {
      corrected[i].T_world_camera = T_world_noted[next];
      continue;
    }
    const auto apart_m = [&](std::size_t k) { return apart(trajectory[i], trajectory[noted[k]]); };
    const bool is_after = next < noted.size() && (next == 0 || apart_m(next) <= apart_m(next - 1));
    const std::size_t nearer = is_after ? next : next - 1;
    const Pose T_corrected_tracked = T_world_noted[nearer] * trajectory[noted[nearer]].T_world_camera.inverse();
    corrected[i].T_world_camera = T_corrected_tracked * trajectory[i].T_world_camera;
  }
  return corrected;
}

Result<std::optional<Trajectory>> LoopRefiner::close(const TrackedWalk& walk, LoopClosure closure) {
  if (!closure.has_loops()) return std::optional<Trajectory>();
  if (!closure.mistracked.empty() && archive_.is_kept()) {
    session_.info("frames were wrongly aligned with older parts of the scan: they are tracked again");
    if (const auto tracked = track_again(closure.mistracked); !tracked) return tracked.error();
    closure = find_loops();
  }
  result_ = described(closure);
  if (!closure.is_corrected) return std::optional<Trajectory>();
  result_->is_corrected = false;  // it is corrected only when the frames have been fused again
  session_.info(fmt::format("the camera came back to a known place with a drift of {:.0f} mm: closing the loop",
                            closure.drift_m * 1000));
  if (!archive_.is_kept()) {
    return Error{ErrorCode::kInput, "closing it needs the frames again, and no recording was made"};
  }
  const Trajectory walked = with_joined_end(walk.trajectory, closure);
  Trajectory corrected = moved(walked, closure.T_world_cameras);
  largest_correction_m_ = farthest_moved_m(walked, corrected);
  wanted_ = corrected.size();
  return std::optional(std::move(corrected));
}

Result<void> LoopRefiner::accept(TsdfVolume& /*volume*/) {
  result_->is_corrected = true;
  result_->largest_correction_m = largest_correction_m_;
  return {};
}

Result<void> LoopRefiner::reject(const Result<std::size_t>& fused) {
  warn_not_closed(
      fused ? Error{ErrorCode::kInput, fmt::format("only {} of {} frames could be read again", *fused, wanted_)}
            : fused.error());
  return {};
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
