// Camera paths for synthetic scenes, and the plan frame in which scenes are drawn.
#pragma once

#include "synth/scene/scene.h"

namespace scanknit {

/// Scenes are drawn on a plan: x right, y away, z up. The world of a recording is a camera's: y down, z away.
[[nodiscard]] Pose T_world_plan();

/// A camera at `eye` that looks at `target`, upright; both in the plan frame. `eye` is not straight above `target`.
[[nodiscard]] Pose look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target);

/// Circles the object while the elevation goes smoothly from +55 to -55 degrees, so that top and underside are seen:
/// the view of a camera on a slowly tilting arm above a turntable.
struct TurntablePath {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double distance_m = 0.6;
  double turns = 3;
};
[[nodiscard]] CameraPath turntable_path(const TurntablePath& path);

/// A circle (or spiral, when the radii differ) round a vertical axis, looking at `target`.
struct OrbitPath {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  double height_m = 1.0;  ///< the camera's height above the floor
  double first_radius_m = 1.0;
  double last_radius_m = 1.0;
  double turns = 1;
};
[[nodiscard]] CameraPath orbit_path(const OrbitPath& path);

/// An elliptic walk in a room. The camera looks ahead and outwards, so that corners and furniture stay in view, and
/// nods slowly.
struct WalkPath {
  double half_length_m = 1.0;  ///< along x
  double half_width_m = 1.0;   ///< along y
  double height_m = 1.4;
};
[[nodiscard]] CameraPath walk_path(const WalkPath& path);

/// A walk round a rectangle with rounded corners, looking ahead and a little outwards. It ends a little beyond the
/// start, so that its last frames see again what the first ones saw.
struct RingPath {
  double half_length_m = 4.0;  ///< along x
  double half_width_m = 3.0;   ///< along y
  double corner_radius_m = 1.0;
  double height_m = 1.4;
  double rounds = 1.08;
};
[[nodiscard]] CameraPath ring_path(const RingPath& path);

/// A straight walk along x, from -half_length_m. It begins looking back to the left and ends looking ahead to the
/// right: half a turn clockwise.
struct CrossingPath {
  double half_length_m = 2.0;
  double height_m = 1.4;
  double first_gaze_rad = 0;  ///< from the x axis, counter-clockwise
};
[[nodiscard]] CameraPath crossing_path(const CrossingPath& path);

/// A straight walk from one point to another, which looks in one direction and swings to both sides of it.
struct StraightPath {
  Eigen::Vector3d from = Eigen::Vector3d::Zero();
  Eigen::Vector3d to = Eigen::Vector3d::Zero();
  double gaze_rad = 0;   ///< from the x axis, counter-clockwise
  double swing_rad = 0;  ///< the farthest, three times on the way
  double slope = 0;      ///< of the line of sight; below 0: downwards
};
[[nodiscard]] CameraPath straight_path(const StraightPath& path);

}  // namespace scanknit
