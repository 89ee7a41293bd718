// The axis and the angles of a turntable that agree best with what was measured between its frames.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fusion/track/motion_vector.h"
#include "fusion/turntable/turntable_axis.h"

namespace scanknit {

/// The camera's motion between two frames, as registration found it.
struct TurntableEdge {
  std::size_t from = 0, to = 0;  ///< places among the angles
  Pose T_from_to = Pose::Identity();
  /// How well it is held: J^T J of residuals in sigma, by translation (m) and rotation (rad) about `centre`, both in
  /// the frame of `from`. Directions that the scene does not hold are 0.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// What is known of the angles from elsewhere, up to a common offset.
struct AnglePrior {
  std::vector<double> angles_rad;  ///< one a frame
  double sigma_rad = 0.01;         ///< of each
};

struct TurntableSolution {
  TurntableMotion motion;
  std::vector<double> sigmas;   ///< of each edge: its distance from the motion, 1 is usual
  std::vector<double> weights;  ///< of each edge: near 0 for one that the others contradict
  double rms_m = 0;             ///< weighted, of what remains of the edges' translations at their centres
  double rms_rad = 0;           ///< and of their rotations
  double angle_sigma_rad = 0;   ///< median over edges: how well the scene alone holds the difference of two angles
  int iterations = 0;
};

/// Least squares over the axis (4 numbers) and all angles but the first, which is 0: Levenberg-Marquardt on the edges'
/// motions in their own information, with the loss of Geman & McClure (1987), sparse Cholesky. Frames without an edge
/// keep their angle, or take the prior's. `start` has one angle a frame. One thread: the same bits every time.
[[nodiscard]] TurntableSolution solve_turntable(const TurntableMotion& start, const std::vector<TurntableEdge>& edges,
                                                const std::optional<AnglePrior>& prior);

}  // namespace scanknit
