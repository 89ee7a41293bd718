// Finds the axis and the angles of a turntable that agree best with the measured motions between its frames.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fusion/register/motion_vector.h"
#include "fusion/turntable/turntable_axis.h"

namespace scanknit {

/// The camera's motion between two frames, from registration.
struct TurntableEdge {
  std::size_t from = 0, to = 0;  ///< indices into the angles
  Pose T_from_to = Pose::Identity();
  /// How well it is determined: J^T J of residuals in sigma, by translation (m) and rotation (rad) about `centre`, both
  /// in the frame of `from`. Directions that the scene does not determine are 0.
  Matrix6d information = Matrix6d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

/// Known angles, up to a common offset.
struct AnglePrior {
  std::vector<double> angles_rad;  ///< one for each frame
  double sigma_rad = 0.01;         ///< standard deviation of each
};

struct TurntableSolution {
  TurntableMotion motion;
  std::vector<double> sigmas;   ///< for each edge: its distance from the motion; typically 1
  std::vector<double> weights;  ///< for each edge: near 0 if the others contradict it
  double rms_m = 0;             ///< weighted, of the edges' remaining translations at their centres
  double rms_rad = 0;           ///< of their remaining rotations
  double angle_sigma_rad = 0;   ///< median over edges: how well the scene alone determines the difference of two angles
  int iterations = 0;
};

/// Least squares over the axis (4 numbers) and all angles except the first, which is 0: Levenberg-Marquardt on the
/// edges' motions, weighted by their information, with the loss of Geman & McClure (1987) and sparse Cholesky. Frames
/// without an edge keep their angle, or take the prior's. `start` has one angle for each frame. One thread: the same
/// bits every time.
[[nodiscard]] TurntableSolution solve_turntable(const TurntableMotion& start, const std::vector<TurntableEdge>& edges,
                                                const std::optional<AnglePrior>& prior);

}  // namespace scanknit
