// Fine registration of two scans that nearly fit.
#pragma once

#include "core/pose.h"
#include "fusion/align/point_grid.h"
#include "fusion/align/scan_model.h"
#include "fusion/register/motion_vector.h"

namespace scanknit {

/// A scan at one scale, with a grid to find neighbours. Movable: the grid refers to the points' memory, which stays.
struct ScanLevel {
  ScanLevel(OrientedPoints points, double spacing_m);
  OrientedPoints points;
  double spacing_m;
  PointGrid grid;  ///< finds neighbours within kReach spacings
  static constexpr double kReach = 3;
};

struct FineMatch {
  Pose T_a_b = Pose::Identity();
  /// Of the last round, a mean over pairs of points: J^T J with J = d residual / d (translation, rotation) of scan b in
  /// its own frame.
  Matrix6d shape = Matrix6d::Zero();
  /// The least eigenvalue of `shape`, about the middle of the pairs and with their radius as the unit of length: at
  /// most 1/3; 0 if the scans could slide or turn along each other.
  double least_strength = 0;
  double residual_m = 0;          ///< weighted root mean square of distances along normals
  bool has_fixed_motion = false;  ///< some motion was not changed, because the scans do not determine it
  std::size_t pairs = 0;          ///< pairs of points; 0: the scans do not meet, and T_a_b is the initial pose
};

/// Point to plane with the sum of both normals (Rusinkiewicz 2019, "A Symmetric Objective Function for ICP"), from both
/// scans to the other, with Tukey's weights. Points whose neighbour is on a rim get no weight. The same bits for any
/// number of threads. T_a_b does not change along motions that the scans determine less than `least_moved` (a strength
/// like `least_strength`): solution remapping (Zhang, Kaess & Singh 2016, "On Degeneracy of Optimization-Based State
/// Estimation Problems"); `shape` then has that strength for them.
[[nodiscard]] FineMatch match_finely(const ScanLevel& a, const ScanLevel& b, const Pose& T_a_b, int iterations,
                                     double least_moved = 0);

}  // namespace scanknit
