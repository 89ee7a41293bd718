// Pose graph: finds the poses that agree best with measured motions between them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/pose.h"
#include "fusion/register/motion_vector.h"

namespace scanknit {

/// A motion that was measured between two nodes.
struct PoseEdge {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();  ///< p_from = T_from_to * p_to
  /// Inverse covariance of T_from_to^-1 * (T_from_to as it truly is): translation (m), then rotation (rad). Symmetric,
  /// positive semidefinite.
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;  ///< a loop: it loses its weight if it contradicts the others
};

struct PoseGraphResult {
  std::vector<double> sigmas;   ///< for each edge: distance of the poses from the measurement, in standard deviations
  std::vector<double> weights;  ///< for each edge in the last round: from 1 (cannot be wrong) to 0 (wrong)
  int iterations = 0;
  bool has_converged = false;
};

/// Distance of an edge from poses, in standard deviations: the root of its squared Mahalanobis distance.
[[nodiscard]] double edge_sigmas(const PoseEdge& edge, const Pose& T_world_from, const Pose& T_world_to);

/// Moves all poses except the first to minimise the sum of squared distances to the edges: Levenberg-Marquardt
/// (Grisetti, Kuemmerle, Stachniss & Burgard 2010, "A Tutorial on Graph-Based SLAM") with a sparse Cholesky
/// factorisation. Weights edges that may be wrong by the loss of Geman & McClure (1987), with graduated non-convexity
/// (Yang, Antonante, Tzoumas & Carlone 2020): all of them count at first, and those farther than `loss_sigmas` do not
/// count in the end. Nodes without an edge do not move. One thread, the same bits every time. SCANKNIT_CHECKs that
/// edges refer to existing nodes.
[[nodiscard]] PoseGraphResult optimise_poses(std::vector<Pose>& T_world_nodes, const std::vector<PoseEdge>& edges,
                                             double loss_sigmas = 4);

}  // namespace scanknit
