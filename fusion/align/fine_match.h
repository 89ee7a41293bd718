// Fine registration: two scans that nearly fit are moved until they do.
#pragma once

#include "core/pose.h"
#include "fusion/align/point_grid.h"
#include "fusion/align/scan_model.h"
#include "fusion/track/motion_vector.h"

namespace scanknit {

/// A scan at one scale, ready to be asked for neighbours. Movable: the grid looks at the points' memory.
struct ScanLevel {
  ScanLevel(OrientedPoints points, double spacing_m);
  OrientedPoints points;
  double spacing_m;
  PointGrid grid;  ///< reaches kReach spacings
  static constexpr double kReach = 3;
};

struct FineMatch {
  Pose T_a_b = Pose::Identity();
  /// Of the last round, a mean over pairs of points: J^T J with J = d residual / d (translation, rotation) of scan b in
  /// its own frame.
  Matrix6d shape = Matrix6d::Zero();
  /// The least eigenvalue of `shape`, seen from the middle of the pairs and with their radius as the unit of length:
  /// 1/3 at most; 0 where the scans could slide or turn along each other.
  double least_strength = 0;
  double residual_m = 0;  ///< root of the weighted mean square distance along normals
  bool is_held = false;   ///< some motion was left as it was, since the scans do not hold it
  std::size_t pairs = 0;  ///< of points; 0: the scans do not meet, and T_a_b is where it began
};

/// Point to plane with the sum of both normals (Rusinkiewicz 2019, "A Symmetric Objective Function for ICP"), from both
/// scans to the other, with Tukey's weights. Points whose neighbour lies on a rim have none. The same bits for any
/// number of threads. Motions that the scans hold less firmly than `least_moved` (as `least_strength`) stay as they are
/// in T_a_b: solution remapping (Zhang, Kaess & Singh 2016, "On Degeneracy of Optimization-Based State Estimation
/// Problems"); `shape` then holds them so firmly.
[[nodiscard]] FineMatch match_finely(const ScanLevel& a, const ScanLevel& b, const Pose& T_a_b, int iterations,
                                     double least_moved = 0);

}  // namespace scanknit
