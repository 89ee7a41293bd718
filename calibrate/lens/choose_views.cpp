#include "calibrate/lens/choose_views.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

/// The logarithm of the determinant.
double log_determinant(const LensMatrix& matrix) {
  return matrix.ldlt().vectorD().cwiseMax(1e-300).array().log().sum();
}

}  // namespace

std::vector<std::size_t> choose_views(const std::vector<LensMatrix>& informations, std::size_t most) {
  LensMatrix all = LensMatrix::Zero();
  for (const LensMatrix& information : informations) all += information;
  // Each parameter in units in which all views together know it: else those of large numbers alone would count.
  const LensVector units = all.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  LensMatrix known = 1e-9 * LensMatrix::Identity();  // a few views alone do not tell all parameters
  std::vector<bool> is_taken(informations.size(), false);
  for (std::size_t taken = 0; taken < std::min(most, informations.size()); ++taken) {
    std::size_t best = 0;
    double best_gain = -INFINITY;
    for (std::size_t i = 0; i < informations.size(); ++i) {
      if (is_taken[i]) continue;
      const double gain = log_determinant(known + units.asDiagonal() * informations[i] * units.asDiagonal());
      if (gain > best_gain) best = i, best_gain = gain;
    }
    is_taken[best] = true;
    known += units.asDiagonal() * informations[best] * units.asDiagonal();
  }
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < is_taken.size(); ++i) {
    if (is_taken[i]) chosen.push_back(i);
  }
  return chosen;
}

}  // namespace scanknit
