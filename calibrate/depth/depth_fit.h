// The systematic error of depth, and the time and pose between depth and colour, from pictures of a board.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/lens/bundle.h"
#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// What depth says of a small part of the board: the means of its pixels, and of 1 / depth there. A plane's 1 / depth
/// is linear over the picture, so that these means lie on the plane.
struct DepthSample {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the straightened depth picture
  double per_m = 0;                                 ///< 1 / depth, > 0
};

/// How the board moves before the depth camera: after t seconds its pose is moved(t speed + t^2 / 2 change, pose).
struct BoardMotion {
  PoseVector speed = PoseVector::Zero(), change = PoseVector::Zero();
};

/// From three poses, of which the first is `before_s` earlier than the second and the last `after_s` later; both > 0.
[[nodiscard]] BoardMotion motion_through(const Pose& before, const Pose& now, const Pose& after, double before_s,
                                         double after_s);

/// The board in one depth picture. Its plane is z = 0 of the board's frame.
struct DepthView {
  std::vector<DepthSample> samples;
  Pose T_depth_board = Pose::Identity();        ///< as colour shows it
  PoseMatrix information = PoseMatrix::Zero();  ///< of that pose, for a step before it: shift, then turn
  std::optional<BoardMotion> motion;            ///< nothing: unknown
};

/// How well depth is known at one distance when it is corrected.
struct DepthDeviation {
  double distance_m = 0, deviation_m = 0;  ///< mean over the picture
};

struct DepthCalibration {
  DepthBias bias;
  double colour_later_s = 0, colour_later_deviation_s = 0;  ///< FrameTiming::colour_later_s
  /// p = correction * p_before in the depth camera's frame, of a point that colour sees; the identity unless asked for.
  Pose correction = Pose::Identity();
  PoseVector correction_deviation = PoseVector::Zero();
  std::array<DepthDeviation, 3> deviations{};  ///< at 1, 2 and 4 m
  double before_m = 0, after_m = 0;            ///< median distance of the samples from the plane, along z
  double nearest_m = 0, farthest_m = 0;        ///< the 5th and 95th percentile of the samples' depth
  std::size_t views = 0, samples = 0;
};

/// Whether the pose between depth and colour is estimated, too.
enum class DepthToColour { kKnown, kEstimated };

/// Fits 1 / z = (1 + scale) / z_measured + shift (DepthBias) to the planes, jointly with the time by which colour is
/// later and the error of each view's pose. Both fields are cubic B-splines whose second differences are small; those
/// of `scale` are a hundred times smaller, which leaves it close to linear over the picture: a wrong focal length or
/// baseline. Iteratively reweighted least squares (Huber 1964); the views' poses are eliminated (Brown 1958).
/// Deviations grow with what the views' poses are off beyond their own deviations (Birge 1932).
/// `camera` is that of the depth pictures. Deterministic.
/// Errors (kTooLittle): fewer than kFewestDepthViews views with samples; depth that is not that of the board.
[[nodiscard]] Result<DepthCalibration> fit_depth(const std::vector<DepthView>& views, const CameraIntrinsics& camera,
                                                 DepthToColour between);

inline constexpr std::size_t kFewestDepthViews = 8;

}  // namespace scanknit
