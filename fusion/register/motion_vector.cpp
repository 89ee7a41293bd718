#include "fusion/register/motion_vector.h"

#include <Eigen/Eigenvalues>

namespace scanknit {

SymmetricModes modes_of(const Matrix6d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace scanknit
