#include "fusion/track/tracker.h"

#include "fusion/track/model_tracker.h"

namespace scanknit {

const char* to_string(TrackState state) {
  switch (state) {
    case TrackState::kOk: return "ok";
    case TrackState::kWeak: return "weak";
    case TrackState::kLost: return "lost";
    case TrackState::kRecovered: return "recovered";
  }
  return "";
}

const char* to_string(TrackReason reason) {
  switch (reason) {
    case TrackReason::kNone: return "";
    case TrackReason::kNothingSeen: return "nothing seen";
    case TrackReason::kTooClose: return "too close";
    case TrackReason::kTooFewPoints: return "too few points";
    case TrackReason::kTooFast: return "too fast";
    case TrackReason::kPlaceNotRecognised: return "place not recognised";
    case TrackReason::kMakingSure: return "making sure";
    case TrackReason::kSceneIsChanging: return "scene is changing";
    case TrackReason::kRecordedPoseDoesNotFit: return "recorded pose does not fit";
    case TrackReason::kFlatScene: return "flat scene";
    case TrackReason::kSceneHasChanged: return "scene has changed";
    case TrackReason::kLittleOverlap: return "little overlap";
    case TrackReason::kRecordedPoseKept: return "recorded pose kept";
    case TrackReason::kFoundLater: return "found later";
    case TrackReason::kFoundFromBothSides: return "found from both sides";
    case TrackReason::kFoundByLoop: return "found by loop";
  }
  return "";
}

Tracker::Tracker(const TrackerConfig& config) : tracker_(std::make_unique<ModelTracker>(config)) {}
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;
Tracker::~Tracker() = default;

TrackResult Tracker::track(const Frame& frame, const TsdfVolume& volume) {
  return tracker_->track(frame, volume);
}

TrackResult Tracker::track_later(const Frame& frame, const TsdfVolume& volume,
                                 const std::optional<KnownFrame>& neighbour) {
  return tracker_->track_later(frame, volume, neighbour);
}

void Tracker::forget_views() {
  tracker_->forget_views();
}

}  // namespace scanknit
