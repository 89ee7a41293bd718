// Tracker: where each frame was taken, by what it shows of the volume.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include "core/frame.h"
#include "core/pose.h"

namespace scanknit {

class ModelTracker;
class TsdfVolume;

enum class TrackState {
  kOk,         ///< the pose is known
  kWeak,       ///< the pose is usable, but some of it is held by little
  kLost,       ///< the pose is not known: such a frame must not be fused
  kRecovered,  ///< known again, after it was not
};

/// "ok", "weak", "lost", "recovered".
[[nodiscard]] const char* to_string(TrackState state);

struct TrackResult {
  TrackState state = TrackState::kLost;
  std::string reason = {};                  ///< why not ok, in a few words of docs/report.md; empty when ok
  Pose T_world_camera = Pose::Identity();   ///< of a lost frame: where it was last known, or seems to be
  std::size_t points = 0;                   ///< of the frame, that were compared with the model
  double overlap = 0;                       ///< share of them before which the model has a surface
  double inlier_share = 0;                  ///< of those, the share that agrees with it
  double contradicted_share = 0;            ///< of those, the share that the model has in quite another depth
  double colour_agreement = 1;              ///< mean weight of the pairs whose colour is compared; 1 where none is
  double rms_sigma = 0;                     ///< of the residuals, in standard deviations of the depth noise
  int weak_directions = 0;                  ///< of the six, those in which the scene does not hold the camera
  std::chrono::nanoseconds raycast_time{};  ///< of the time it took, what was spent on looking at the volume

  [[nodiscard]] bool is_lost() const { return state == TrackState::kLost; }
};

/// What the tracker makes of poses that a recording has.
enum class PosePrior {
  kIgnore,  ///< only the first frame's pose is taken, so that the world is the recording's
  kRefine,  ///< each is where registration starts; a large correction must fit well
};

/// Finds the poses of frames, one after the other.
class Tracker {
 public:
  explicit Tracker(PosePrior prior = PosePrior::kIgnore);
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;
  ~Tracker();

  /// Finds the frame's pose in the world of `volume`, which holds the frames fused so far. Frames come in their order;
  /// `frame` is filtered and has normals. The first frame's pose is the recording's, or the world's origin. A frame
  /// whose pose is not believed is lost: that is a state, no error, and later frames are found again by what they see.
  [[nodiscard]] TrackResult track(const Frame& frame, const TsdfVolume& volume);

 private:
  std::unique_ptr<ModelTracker> tracker_;
};

}  // namespace scanknit
