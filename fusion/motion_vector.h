// Small motions as six numbers: translation, then rotation.
#pragma once

#include <Eigen/Core>

namespace scanknit {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

}  // namespace scanknit
