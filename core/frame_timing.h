// FrameTiming: when a sensor takes the parts of a frame (rolling shutter, colour that is taken later than depth).
// FrameMotion: how the camera moves meanwhile.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "core/camera.h"
#include "core/pose.h"

namespace scanknit {

/// Zero: all at once. A frame's time is that of the middle row of its depth picture.
struct FrameTiming {
  double readout_s = 0;       ///< from the first row of a picture to the last (rolling shutter), >= 0
  double colour_later_s = 0;  ///< the colour picture is taken so long after the depth picture; < 0: before it

  [[nodiscard]] bool is_at_once() const { return readout_s == 0 && colour_later_s == 0; }
};

/// A steady motion of the camera over some time, in the camera's axes.
struct SteadyMotion {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< rotation vector
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();

  /// The motion that leads from one pose to the other: T_before_after = before.inverse() * after.
  [[nodiscard]] static SteadyMotion from(const Pose& T_before_after) {
    const Eigen::AngleAxisd turn(T_before_after.linear());
    return {turn.angle() * turn.axis(), T_before_after.translation()};
  }

  /// The pose after a share of the time, in the axes of the beginning. `share` may be negative, or more than 1.
  [[nodiscard]] Pose after(double share) const {
    Pose pose = Pose::Identity();
    const double angle = turn_rad.norm();
    if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle * share, turn_rad / angle).toRotationMatrix();
    pose.translation() = share * shift_m;
    return pose;
  }

  [[nodiscard]] SteadyMotion operator*(double share) const { return {share * turn_rad, share * shift_m}; }

  [[nodiscard]] bool is_still() const { return turn_rad.isZero(0) && shift_m.isZero(0); }

  /// How far a point at depth_m moves in the picture, pixels.
  [[nodiscard]] double pixels(const CameraIntrinsics& camera, double depth_m) const {
    return std::abs(camera.fx) * (turn_rad.norm() + shift_m.norm() / depth_m);
  }
};

/// The camera's pose when it reads row y of a picture, in its axes at the middle row: p_middle = pose * p_row. `rows`
/// is the motion from the first row to the last; rows are read from top to bottom.
[[nodiscard]] inline Pose pose_of_row(const SteadyMotion& rows, double y, int height) {
  return rows.after((y + 0.5) / height - 0.5);
}

/// A frame's pose is that of the middle row of its depth picture.
struct FrameMotion {
  SteadyMotion rows;       ///< while the rows of a picture are read, from the first to the last
  SteadyMotion to_colour;  ///< from the time of the depth picture to that of the colour picture

  [[nodiscard]] bool is_still() const { return rows.is_still() && to_colour.is_still(); }
};

}  // namespace scanknit
