// What of a LiDAR's points is a return.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace scanknit {

/// False for what files write where nothing came back: a point that is not finite, farther than 100 km, or at the
/// sensor itself.
[[nodiscard]] inline bool is_lidar_return(const Eigen::Vector3d& p) {
  constexpr double kFarthest_m = 1e5, kNearest_m = 0.01;
  return p.allFinite() && p.cwiseAbs().maxCoeff() < kFarthest_m && p.norm() > kNearest_m;
}

}  // namespace scanknit
