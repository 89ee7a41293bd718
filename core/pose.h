// Pose: a rigid motion, named T_target_source. p_target = T_target_source * p_source.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/result.h"

namespace scanknit {

using Pose = Eigen::Isometry3d;

/// The pose held by a 4x4 matrix from a file. Refused (ErrorCode::kInput, with what is wrong): a value that is not
/// finite; a last row other than (0 0 0 1); a rotation part R with |R^T R - I| > 0.01 in any entry, or det R < 0.
/// The small deviations of printed matrices are removed: the result's rotation is the nearest rotation to R.
[[nodiscard]] Result<Pose> pose_from_matrix(const Eigen::Matrix4d& matrix);

/// The pose at `fraction` in [0, 1] between two: straight line for the position, shortest arc for the rotation.
[[nodiscard]] Pose interpolate(const Pose& from, const Pose& to, double fraction);

/// True when every entry is finite and the linear part is a rotation within 1e-6.
[[nodiscard]] bool is_rigid(const Pose& pose);

}  // namespace scanknit
