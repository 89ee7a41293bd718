// Registers a depth frame with a view of the model: projective point-to-plane ICP with a photometric term.
#pragma once

#include <optional>

#include "core/frame_timing.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/register/motion_vector.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// The camera moves while it takes a frame, as it has since the frame before. Times are shares of the time since then.
struct MovingCamera {
  Pose T_model_before;      ///< pose of the frame before
  double readout = 0;       ///< time from the first row to the last (rolling shutter)
  double colour_sigma = 0;  ///< standard deviation of the time when colour is taken; 0: it is not searched for

  /// The motion since the frame before, of a frame at `T_model_frame`.
  [[nodiscard]] SteadyMotion motion(const Pose& T_model_frame) const {
    return SteadyMotion::from(T_model_before.inverse() * T_model_frame);
  }
};

struct IcpConfig {
  NoiseModel noise;
  double intensity_sigma = 0.05;  ///< of the difference of intensity between frame and model; 0: use only depth
  int first_level = 2;            ///< begin at this level; 2 is the coarsest
  int last_level = 0;             ///< and end at this one
  std::optional<MovingCamera> moving = std::nullopt;  ///< nothing: all of the frame is taken at once
  double colour_later = 0;  ///< where the search for the time of colour begins: IcpResult::colour_later
  /// Colour shows what depth shows at the same time. Then, and where its time is searched for, differences of intensity
  /// count for more than distances: neighbouring pixels share most of the error of depth, and none of that of colour.
  bool colour_is_timely = false;
  bool asks_if_colour_is_late = false;  ///< sets IcpResult::colour_seems_later
  bool keeps_pose = false;              ///< only measure how well the frame fits at the given pose, at `last_level`
};

struct IcpResult {
  Pose T_model_frame = Pose::Identity();  ///< p_model_camera = T_model_frame * p_frame_camera
  std::size_t points = 0;                 ///< of the frame, at the last level
  double overlap = 0;                     ///< share of the points at which the model has a surface
  double inlier_share = 0;  ///< share of those within 3 sigma of the model's plane, with similar position and normal
  double contradicted_share = 0;  ///< share of those at which the model has a very different depth
  double changed_share = 0;       ///< share of those in patches that have changed: changed_share(), unless coarse
  double rms_sigma = 0;           ///< of the weighted residuals, in standard deviations of the depth noise
  double colour_agreement = 1;    ///< mean weight of the pairs whose colour is compared; 1 without such pairs
  /// How much later colour was taken than the frame's intensities assume; a share of the time since the frame before.
  double colour_later = 0;
  /// The same for a time that is not searched for, as the pairs alone have it. Nothing where the camera moves the
  /// picture by less than a pixel, or the scene does not determine the motion.
  std::optional<double> colour_seems_later = std::nullopt;
  double support = 0;  ///< weight of the pairs for each point, with colour: to compare starts
  /// How well the pairs determine each direction of motion, ascending: 1 if all points do. Translation in metres and
  /// rotation times the mean depth have the same unit here.
  Vector6d strengths = Vector6d::Zero();
  int weak_directions = 0;  ///< number of directions that are too weak: the result does not move along them
  /// J^T J of the residuals in sigma, by translation (m) and rotation (rad) about `centre`, both in the model's camera;
  /// 0 along directions that are too weak. Points count as if their errors were independent, which they are not.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// The same for an edge of a pose graph: of a motion (m, rad) of the frame in its own axes, T_model_frame * motion,
  /// where 1 / m^2 is a translation that all points determine. Divided by the variance of a plane's distance (m^2) it
  /// is the inverse covariance.
  Matrix6d shape = Matrix6d::Zero();

  [[nodiscard]] std::size_t inliers() const {
    return static_cast<std::size_t>(static_cast<double>(points) * overlap * inlier_share + 0.5);
  }
};

/// Moves the frame onto the model, from `T_model_frame`. Pairs by projection (Blais & Levine 1995), distances to planes
/// (Chen & Medioni 1991), Tukey's weights on residuals in sigma(z), narrowing from level to level; Gauss-Newton with
/// the 6 x 6 system in double. With a rolling shutter each row has its own pose, which follows the frame's (as Kerl,
/// Stueckler & Cremers 2015, "Dense continuous-time tracking and mapping with rolling shutter RGB-D cameras"). The time
/// of colour is one more unknown, which moves the colours along the camera's path (as Li & Mourikis 2014, "Online
/// temporal calibration for camera-IMU systems", move features): else colour would pull where the camera turns. Finds
/// directions that the scene does not determine by the eigenvalues, and does not move along them (Zhang, Kaess & Singh
/// 2016, "On degeneracy of optimization-based state estimation problems"). The same bits for any number of threads and
/// instruction set. Never fails: without pairs it returns the given pose, with `overlap` 0.
[[nodiscard]] IcpResult register_frame(const SurfacePyramid& frame, const SurfacePyramid& model,
                                       const Pose& T_model_frame, const IcpConfig& config);

}  // namespace scanknit
