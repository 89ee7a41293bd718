// Tracker: finds the camera's pose by registering each frame with the volume.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/frame.h"
#include "core/frame_timing.h"
#include "core/pose.h"

namespace scanknit {

class ModelTracker;
class TsdfVolume;

enum class TrackState {
  kOk,         ///< the pose is known
  kWeak,       ///< the pose is usable, but parts of it are determined badly
  kLost,       ///< the pose is unknown: the frame must not be fused
  kRecovered,  ///< the pose is known again, after it was lost
};

/// "ok", "weak", "lost", "recovered".
[[nodiscard]] const char* to_string(TrackState state);

/// Why a frame's pose is lost, or weak. docs/report.md describes each.
enum class TrackReason {
  kNone,
  kNothingSeen,
  kTooClose,
  kTooFewPoints,
  kTooFast,
  kPlaceNotRecognised,
  kMakingSure,
  kSceneIsChanging,
  kRecordedPoseDoesNotFit,
  kFlatScene,
  kSceneHasChanged,
  kLittleOverlap,
  kRecordedPoseKept,
  kFoundLater,          ///< by track_later()
  kFoundFromBothSides,  ///< tracked apart from the scan, from the frames before and after it, which agree
  kFoundByLoop,         ///< tracked apart from the scan, and joined to it by a loop
};

/// The same words as in docs/report.md: "nothing seen"; "" for kNone.
[[nodiscard]] const char* to_string(TrackReason reason);

struct TrackResult {
  TrackState state = TrackState::kLost;
  TrackReason reason = TrackReason::kNone;  ///< why not ok
  Pose T_world_camera = Pose::Identity();   ///< of a lost frame: the last known pose, or a guess
  std::size_t points = 0;                   ///< points of the frame that were compared with the model
  double overlap = 0;                       ///< share of them at which the model has a surface
  double inlier_share = 0;                  ///< share of those that agrees with it
  double contradicted_share = 0;            ///< share of those at which the model has a very different depth
  double changed_share = 0;                 ///< share of those in patches of the picture where the scene has changed
  double colour_agreement = 1;              ///< mean weight of the pairs whose colour is compared; 1 without such pairs
  double rms_sigma = 0;                     ///< of the residuals, in standard deviations of the depth noise
  int weak_directions = 0;                  ///< how many of the six the scene does not determine
  /// How much later colour was taken than the sensor's timing says; a share of the time since the frame before.
  double colour_later = 0;
  FrameMotion motion = {};                  ///< of the camera while it took the frame, as far as its timing is known
  std::chrono::nanoseconds raycast_time{};  ///< the part of the time that raycasting took

  [[nodiscard]] bool is_lost() const { return state == TrackState::kLost; }
};

/// A frame whose pose is known.
struct KnownFrame {
  Pose T_world_camera = Pose::Identity();
  std::int64_t timestamp_ns = 0;
};

/// How the tracker uses the poses of a recording.
enum class PosePrior {
  kIgnore,  ///< use only the first frame's pose, so that the world is the recording's
  kRefine,  ///< start registration from each; a large correction must fit well
};

struct TrackerConfig {
  PosePrior prior = PosePrior::kIgnore;
  FrameTiming timing = {};  ///< of the sensor
};

/// Whether the time of colour is one more unknown of registration. With a sensor whose timing is unknown it is not
/// searched for: there it would also explain what a rolling shutter does, and the camera would be lost in quick turns.
[[nodiscard]] inline bool searches_colour_time(const FrameTiming& timing, const Frame& frame) {
  return frame.has_clock && !timing.is_at_once();
}

/// Finds the poses of frames, one after the other.
class Tracker {
 public:
  explicit Tracker(const TrackerConfig& config = {});
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;
  ~Tracker();

  /// Finds the frame's pose in the world of `volume`, which holds the frames fused so far. Frames come in their order,
  /// or all in reverse order; `frame` is filtered and has normals. The first frame's pose is the recording's, or the
  /// world's origin. A frame whose pose is not accepted is lost: this is a state, not an error, and relocalisation
  /// finds the pose of later frames.
  [[nodiscard]] TrackResult track(const Frame& frame, const TsdfVolume& volume);

  /// Finds the pose of a frame that was lost, when `volume` holds what was seen before and after it: from `neighbour`,
  /// a frame shortly before or after it; without one, at the places that it looks like. The result is kRecovered, or
  /// kLost unless the frame fits as well as frames usually do. Does not change what track() does next.
  [[nodiscard]] TrackResult track_later(const Frame& frame, const TsdfVolume& volume,
                                        const std::optional<KnownFrame>& neighbour);

  /// Must be called when `volume` has changed otherwise than by fusing frames whose poses were found.
  void forget_views();

 private:
  std::unique_ptr<ModelTracker> tracker_;
};

}  // namespace scanknit
