// Pose: a rigid motion, named T_target_source. p_target = T_target_source * p_source.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/result.h"

namespace scanknit {

using Pose = Eigen::Isometry3d;

/// The pose of a 4x4 matrix from a file. Errors (kInput, with the reason): a value that is not finite; a last row other
/// than (0 0 0 1); a rotation part R with |R^T R - I| > 0.01 in any entry, or det R < 0; a position beyond 1e9 m on one
/// of the axes. Removes the rounding of printed matrices: the result has the rotation nearest to R.
[[nodiscard]] Result<Pose> pose_from_matrix(const Eigen::Matrix4d& matrix);

/// Interpolates between two poses at `fraction` in [0, 1]: the position on a straight line, the rotation on the
/// shortest arc.
[[nodiscard]] Pose interpolate(const Pose& from, const Pose& to, double fraction);

/// True when every entry is finite and the linear part is a rotation within 1e-6.
[[nodiscard]] bool is_rigid(const Pose& pose);

}  // namespace scanknit
