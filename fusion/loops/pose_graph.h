// Pose graph: poses that agree as well as they can with what was measured between them.
#pragma once

#include <cstddef>
#include <vector>

#include "core/pose.h"
#include "fusion/track/motion_vector.h"

namespace scanknit {

/// A motion that was measured between two nodes.
struct PoseEdge {
  std::size_t from = 0, to = 0;
  Pose T_from_to = Pose::Identity();  ///< p_from = T_from_to * p_to
  /// Inverse covariance of T_from_to^-1 * (T_from_to as it truly is): translation (m), then rotation (rad). Symmetric,
  /// positive semidefinite.
  Matrix6d information = Matrix6d::Identity();
  bool may_be_wrong = false;  ///< a loop: it loses its weight when it contradicts all the others
};

struct PoseGraphResult {
  std::vector<double> sigmas;   ///< of each edge: how far the poses are from what was measured, in standard deviations
  std::vector<double> weights;  ///< of each edge in the last round: 1 for what cannot be wrong, 0 for what is
  int iterations = 0;
  bool has_converged = false;
};

/// Distance of an edge from poses, in standard deviations: the root of its squared Mahalanobis distance.
[[nodiscard]] double edge_sigmas(const PoseEdge& edge, const Pose& T_world_from, const Pose& T_world_to);

/// Moves all poses but the first so that the sum of squared distances to the edges becomes least: Levenberg-Marquardt
/// (Grisetti, Kuemmerle, Stachniss & Burgard 2010, "A Tutorial on Graph-Based SLAM") with a sparse Cholesky
/// factorisation. Edges that may be wrong are weighed as by Geman & McClure (1987), by graduated non-convexity (Yang,
/// Antonante, Tzoumas & Carlone 2020): they all count in the beginning, and those farther than `loss_sigmas` do not in
/// the end. Nodes that no edge reaches stay. One thread, the same bits every time. SCANKNIT_CHECKs that edges name
/// nodes.
[[nodiscard]] PoseGraphResult optimise_poses(std::vector<Pose>& T_world_nodes, const std::vector<PoseEdge>& edges,
                                             double loss_sigmas = 4);

}  // namespace scanknit
