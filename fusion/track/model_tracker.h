// ModelTracker: the work of a Tracker. Frames are registered with views of the volume; a camera that is lost is found
// again by the places that it saw.
#pragma once

#include <chrono>
#include <cstdint>
#include <list>
#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/register/icp.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/track/colour_lateness.h"
#include "fusion/track/relocaliser.h"
#include "fusion/track/tracker.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

class ModelTracker {
 public:
  explicit ModelTracker(const TrackerConfig& config) : prior_(config.prior), timing_(config.timing) {}

  /// Tracker::track().
  [[nodiscard]] TrackResult track(const Frame& frame, const TsdfVolume& volume);
  /// Tracker::track_later().
  [[nodiscard]] TrackResult track_later(const Frame& frame, const TsdfVolume& volume,
                                        const std::optional<KnownFrame>& neighbour);
  /// Tracker::forget_views().
  void forget_views() { views_.clear(); }

 private:
  /// The last frame whose pose is known, or good enough to continue from.
  struct Known {
    Pose T_world_camera;
    std::int64_t timestamp_ns;
    double depth_m;  ///< typical depth of the frame
  };
  /// A pose, and how well the frame fits the volume at it.
  struct Fit {
    Pose T_world_camera = Pose::Identity();
    IcpResult icp;
  };
  /// A recognised place, and the number of frames in a row that fitted there.
  struct Recognised {
    Pose T_world_camera;
    int views;
  };
  struct Model {
    Pose T_world_camera;
    SurfacePyramid pyramid;
  };

  /// What is seen from a place.
  struct View {
    CameraIntrinsics camera;
    Model model;
  };

  /// The last frame that was fused.
  struct Fused {
    Pose T_world_camera;
    SurfaceLevel level;
  };

  /// The newest frame's pictures, and what was found.
  struct Newest {
    DepthImage depth_m;
    ColourImage colour;  ///< empty: none
    TrackResult found;
  };

  /// How well a frame fits.
  struct Quality {
    double inlier_share = 0;
    double colour_agreement = 0;
    double contradicted_share = 1;
    double changed_share = 1;
  };

  [[nodiscard]] bool is_repeated(const Frame& frame) const;
  [[nodiscard]] TrackResult track_new(const Frame& frame);
  [[nodiscard]] TrackResult follow(const Frame& frame, const SurfacePyramid& seen);
  [[nodiscard]] bool stands_still(const SurfacePyramid& seen) const;
  [[nodiscard]] TrackResult keep_pose(const SurfacePyramid& seen);
  [[nodiscard]] TrackResult refine(const Frame& frame, const SurfacePyramid& seen);
  [[nodiscard]] Model raycast_model(const CameraIntrinsics& camera, const Pose& T_world_camera);
  [[nodiscard]] const Model& view_of_place(const CameraIntrinsics& camera, const Pose& T_world_place);
  [[nodiscard]] Fit fit(const SurfacePyramid& seen, const Model& model, const std::vector<Pose>& T_world_guesses,
                        const std::optional<MovingCamera>& moving);
  [[nodiscard]] double seconds_since_last(const Frame& frame) const;
  [[nodiscard]] SteadyMotion expected_to_colour(const Frame& frame) const;
  [[nodiscard]] MovingCamera moving_since(const Pose& T_world_other, double apart_s, const Frame& frame) const;
  [[nodiscard]] FrameMotion motion_of(const MovingCamera& moving, double apart_s, const TrackResult& result) const;
  [[nodiscard]] Fit fit_near(const SurfacePyramid& seen, const Pose& expected);
  [[nodiscard]] Fit follow_motion(const SurfacePyramid& seen, std::int64_t timestamp_ns);
  [[nodiscard]] std::optional<Fit> sure_fit(const SurfacePyramid& seen, const Pose& T_world_place,
                                            const std::optional<MovingCamera>& moving = std::nullopt);
  [[nodiscard]] std::optional<Fit> find_again(const SurfacePyramid& seen);
  [[nodiscard]] bool is_accepted(const Fit& fit, std::int64_t timestamp_ns) const;
  [[nodiscard]] bool is_worth_following(const Fit& fit, std::int64_t timestamp_ns) const;
  [[nodiscard]] bool is_surprise(const Fit& fit, std::int64_t timestamp_ns) const;
  [[nodiscard]] bool is_elsewhere(const Fit& fit, std::int64_t timestamp_ns) const;
  [[nodiscard]] bool is_steady(const IcpResult& fit) const;
  [[nodiscard]] bool is_sure(const IcpResult& fit) const;
  [[nodiscard]] bool is_as_usual(const IcpResult& fit) const;
  [[nodiscard]] bool knows_usual_quality() const;
  [[nodiscard]] bool is_suddenly_worse(const IcpResult& fit) const;
  [[nodiscard]] bool is_prompt(std::int64_t timestamp_ns) const;
  [[nodiscard]] double intervals_since_last(std::int64_t timestamp_ns) const;
  [[nodiscard]] Pose predicted(std::int64_t timestamp_ns) const;
  void learn_lateness(const Fit& followed, const SurfacePyramid& seen);
  void remember(const Frame& frame, const SurfacePyramid& seen, const TrackResult& result);
  void learn_quality(const TrackResult& result);

  PosePrior prior_;
  FrameTiming timing_;
  std::optional<Known> last_;
  std::optional<Newest> newest_;
  std::optional<Fused> last_moved_;    ///< the last fused frame in which the camera had moved
  std::optional<Pose> T_before_last_;  ///< the camera's motion between the last two frames, if both poses are known
  std::int64_t interval_ns_ = 0;       ///< time between the last two frames with known poses
  bool is_lost_ = false;
  int unsure_frames_ = 0;  ///< last frames whose poses were good enough to continue from, but not to fuse
  std::optional<Recognised> recognised_;
  Quality last_quality_;     ///< of the frame last_
  Quality usual_;            ///< slow average over frames that are ok ...
  int usual_frames_ = 0;     ///< ... the number of them
  double noise_scale_ = 1;   ///< the camera's noise, as a multiple of the configured one
  ColourLateness lateness_;  ///< where the time of colour is not searched for
  Relocaliser places_;
  std::list<View> views_;  ///< from places at which a lost camera was looked for, the newest first

  // Set while a frame is tracked.
  const TsdfVolume* volume_ = nullptr;
  NoiseModel noise_;
  std::optional<MovingCamera> moving_;  ///< T_model_before is T_world_before
  double apart_s_ = 0;                  ///< time since the frame from which the motion is counted
  std::chrono::nanoseconds raycast_time_{};
};

}  // namespace scanknit
