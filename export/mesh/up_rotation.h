// The rotation that makes another axis point up.
#pragma once

#include <Eigen/Core>

#include "core/axes.h"

namespace scanknit {

/// The axis as a unit vector.
[[nodiscard]] Eigen::Vector3f direction(UpAxis axis);

/// The rotation (determinant +1, entries 0 and +-1: exact in floating point) that takes direction `from` to direction
/// `to`. Between perpendicular axes: the quarter turn about their common perpendicular. Between opposite axes: the half
/// turn about x, or about y when the axis is x itself; so a camera's world (y down) becomes y up by diag(1, -1, -1).
[[nodiscard]] Eigen::Matrix3f up_rotation(UpAxis from, UpAxis to);

/// "X", "-Y" and so on.
[[nodiscard]] const char* to_string(UpAxis axis);

}  // namespace scanknit
