// Bundle: a lens and the board's poses in many pictures, estimated together.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "calibrate/lens/lens.h"
#include "core/pose.h"

namespace scanknit {

/// A small motion: shift, then turn (rotation vector), both in the frame that the pose leads to.
using PoseVector = Eigen::Matrix<double, 6, 1>;
using PoseMatrix = Eigen::Matrix<double, 6, 6>;

/// exp(turn), shift, after `pose`.
[[nodiscard]] Pose moved(const PoseVector& step, const Pose& pose);

/// What turns a step of a pose in one frame into the step of the same motion in another one, `T_other_frame` away: the
/// adjoint of that.
[[nodiscard]] PoseMatrix step_seen_from(const Pose& T_other_frame);

/// One picture's corners on the board (metres, z = 0) and in the picture; both lists are of one length.
struct BundleView {
  std::vector<Eigen::Vector2d> board_m, pixels;
  Pose T_camera_board = Pose::Identity();
};

struct Bundle {
  LensVector lens = LensVector::Zero();
  std::vector<BundleView> views;
};

/// How many numbers of the lens are free, from the front; the others stay.
enum class FreeLens { kNone = 0, kPinhole = 4, kTwoRadial = 6, kWithoutK3 = 8, kAll = 9 };

/// Residuals beyond it pull no stronger than at it (Huber 1964), pixels.
inline constexpr double kNoHuber = std::numeric_limits<double>::infinity();

/// descend() (levenberg_marquardt.h) on the sum of squared distances between seen and projected corners. Poses are
/// eliminated view by view (Brown 1958). Begins at the bundle's own values, in which every corner is
/// in front of the camera.
void optimise(Bundle& bundle, FreeLens free, double huber_px = kNoHuber);

/// Seen minus projected, pixels, of each corner; infinite where the corner would be behind the camera.
[[nodiscard]] std::vector<Eigen::Vector2d> residuals(const LensVector& lens, const BundleView& view);

/// What the corners tell of the view's own pose when the lens is known, for residuals of deviation 1: of the step of
/// moved().
[[nodiscard]] PoseMatrix pose_information(const LensVector& lens, const BundleView& view);

/// What one view tells of the lens when its own pose is unknown: the Schur complement of the normal equations, for
/// residuals of deviation 1. Rows and columns beyond `free` are zero.
[[nodiscard]] LensMatrix information(const LensVector& lens, const BundleView& view, FreeLens free);

}  // namespace scanknit
