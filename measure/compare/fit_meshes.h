// Registers a mesh with a reference that is near.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"
#include "measure/compare/signed_distance.h"

namespace scanknit {

struct FitConfig {
  int rounds = 60;           ///< at most
  double least_step = 1e-7;  ///< ends when a round moves the points by less than this times their spread
};

/// Returns T_reference_mesh, near `start`. Point to plane (Chen & Medioni 1991), with weights that fall beyond the
/// typical distance (Cauchy), so that a dent does not pull the rest along. `points` lie on the mesh. A motion that the
/// shape leaves open, as a ball's turns, is not made. The same bits for any number of threads.
[[nodiscard]] Pose fit_points(const std::vector<Eigen::Vector3d>& points, const SignedDistance& reference,
                              const Pose& start, const FitConfig& config = {});

}  // namespace scanknit
