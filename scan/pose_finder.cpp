#include "scan/pose_finder.h"

#include <algorithm>
#include <chrono>

#include "core/check.h"

namespace scanknit {
namespace {

PosePrior prior_of(PoseMode mode) {
  return mode == PoseMode::kRefine ? PosePrior::kRefine : PosePrior::kIgnore;
}

double milliseconds(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

}  // namespace

TrackedFrame described(const Frame& frame, const TrackResult& tracked) {
  return {.sequence = frame.sequence,
          .state = tracked.state,
          .reason = tracked.reason,
          .overlap = tracked.overlap,
          .inlier_share = tracked.inlier_share,
          .rms_sigma = tracked.rms_sigma,
          .points = tracked.points,
          .weak_directions = tracked.weak_directions};
}

bool has_seen_enough(const TrackedFrame& frame) {
  return frame.reason != TrackReason::kNothingSeen && frame.reason != TrackReason::kTooClose &&
         frame.reason != TrackReason::kTooFewPoints;
}

PoseFinder::PoseFinder(PoseMode mode, const FrameTiming& timing) : mode_(mode), tracker_({prior_of(mode), timing}) {
  SCANKNIT_CHECK(mode != PoseMode::kAuto);
}

std::optional<PoseFinder::Found> PoseFinder::find(const Frame& frame, const TsdfVolume& volume, ScanSession& session) {
  if (!is_tracked(mode_)) return frame.T_world_camera ? std::optional(Found{*frame.T_world_camera}) : std::nullopt;
  if (!tracking_) tracking_ = TrackingResult{prior_of(mode_), {}};
  const PeakMemoryWatch track_memory = session.watch_memory("track"), raycast_memory = session.watch_memory("raycast");
  const auto begin = std::chrono::steady_clock::now();
  const TrackResult tracked = tracker_.track(frame, volume);
  const auto spent = std::chrono::steady_clock::now() - begin;
  session.note_time("track", milliseconds(spent - tracked.raycast_time));
  session.note_time("raycast", milliseconds(tracked.raycast_time));
  tracking_->frames.push_back(described(frame, tracked));
  if (tracked.is_lost()) return std::nullopt;
  return Found{tracked.T_world_camera, tracked.motion};
}

TrackResult PoseFinder::find_later(const Frame& frame, const TsdfVolume& volume,
                                   const std::optional<KnownFrame>& neighbour, ScanSession& session) {
  return session.timed("track_later", [&] { return tracker_.track_later(frame, volume, neighbour); });
}

void PoseFinder::note_found_later(const TrackedFrame& found) {
  const auto noted = std::find_if(tracking_->frames.begin(), tracking_->frames.end(),
                                  [&](const TrackedFrame& other) { return other.sequence == found.sequence; });
  SCANKNIT_CHECK(noted != tracking_->frames.end());
  *noted = found;
  noted->state = TrackState::kRecovered;
  ++tracking_->found_later;
}

}  // namespace scanknit
