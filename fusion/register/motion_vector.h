// Small motions as six numbers: translation, then rotation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/pose.h"

namespace scanknit {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The eigenvalues of a symmetric matrix, in ascending order, and their eigenvectors.
struct SymmetricModes {
  Vector6d values = Vector6d::Zero();
  Matrix6d vectors = Matrix6d::Identity();
};

/// Reads the lower triangle. Eigen's solver takes the compiler seconds wherever it is called.
[[nodiscard]] SymmetricModes modes_of(const Matrix6d& symmetric);

/// The angle of its rotation, radians.
[[nodiscard]] inline double angle_of(const Pose& motion) {
  return Eigen::AngleAxisd(motion.linear()).angle();
}

/// cross_matrix(v) * w = v x w.
[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d cross;
  cross << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return cross;
}

}  // namespace scanknit
