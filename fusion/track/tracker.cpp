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

Tracker::Tracker(const TrackerConfig& config) : tracker_(std::make_unique<ModelTracker>(config)) {}
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;
Tracker::~Tracker() = default;

TrackResult Tracker::track(const Frame& frame, const TsdfVolume& volume) {
  return tracker_->track(frame, volume);
}

}  // namespace scanknit
