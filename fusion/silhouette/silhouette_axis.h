// The axis of a turntable, from silhouettes alone.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/pose.h"
#include "core/result.h"
#include "fusion/silhouette/silhouette.h"

namespace scanknit {

/// One picture of a camera that stands still, before a thing that turns.
struct TurnedSilhouette {
  const Silhouette* silhouette = nullptr;
  double angle_rad = 0;  ///< by which the thing has turned, in either direction round the axis
};

struct SilhouetteAxis {
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit, camera frame; the thing turns by +angle round it
  Eigen::Vector3d point = Eigen::Vector3d::UnitZ();      ///< on the axis, metres
  double off_px = 0;                                     ///< root mean square of what is left
  double other_off_px = 0;                               ///< the same if the thing turned the other way
};

/// Finds the axis by which the silhouettes agree: a plane through the centres of two cameras that touches the thing
/// touches both of its outlines (the epipolar tangency of K.-Y. K. Wong and R. Cipolla 2001; C. Hernandez, F. Schmitt
/// and R. Cipolla 2007). Silhouettes do not tell the size of a thing: `distance_m` is the depth at which the axis
/// passes the middle of the picture. Errors (kInput): fewer than four pictures, a silhouette without the thing or one
/// that the picture's border cuts, angles that are all alike, no axis that explains the silhouettes to three pixels.
[[nodiscard]] Result<SilhouetteAxis> find_silhouette_axis(std::span<const TurnedSilhouette> pictures,
                                                          const CameraIntrinsics& camera, double distance_m);

/// The poses of the camera as the thing sees them, in the world of the camera at angle 0.
[[nodiscard]] std::vector<Pose> poses_round(const SilhouetteAxis& axis, std::span<const TurnedSilhouette> pictures);

}  // namespace scanknit
