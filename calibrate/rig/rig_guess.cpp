#include "calibrate/rig/rig_guess.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "core/median.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

constexpr double kAgreeing = 3 * kDegree;
constexpr double kCoarse_s = 0.02, kFine_s = 0.002;
constexpr double kNearlyShared_s = 0.05;

/// The mean of rotations that `weights` says (Markley et al. 2007).
Eigen::Quaterniond mean_of(const std::vector<Eigen::Quaterniond>& turns, const std::vector<double>& weights) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < turns.size(); ++i) sum += weights[i] * turns[i].coeffs() * turns[i].coeffs().transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  return Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3)));
}

/// How well two cameras agree on one rotation between them.
struct Agreement {
  double score = 0;  ///< views that agree; one that agrees less counts less
  Eigen::Quaterniond mean = Eigen::Quaterniond::Identity();
};

Agreement agreement_of(const std::vector<Eigen::Quaterniond>& turns) {
  Agreement result;
  if (turns.empty()) return result;
  std::vector<double> weights(turns.size(), 1);
  for (int round = 0; round < 3; ++round) {
    result.mean = mean_of(turns, weights);
    result.score = 0;
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const double share = result.mean.angularDistance(turns[i]) / kAgreeing;
      result.score += std::max(0.0, 1 - share * share);
      weights[i] = 1 / (1 + share * share);
    }
  }
  return result;
}

/// Some views of b, evenly spread, and what a sees at their times.
class Pair {
 public:
  Pair(const BoardTrack& a, const BoardTrack& b) : a_(a), b_(b) {}

  [[nodiscard]] Agreement at(double lag_s) const {
    constexpr std::size_t kMost = 150;
    std::vector<Eigen::Quaterniond> turns;
    const std::size_t step = (b_.views().size() + kMost - 1) / kMost;
    for (std::size_t i = 0; i < b_.views().size(); i += step) {
      const auto pose = a_.pose_at(b_.views()[i].time_s + lag_s);
      if (pose) turns.emplace_back(pose->linear() * b_.poses()[i].linear().transpose());
    }
    return agreement_of(turns);
  }

  /// The lag with the best score between two, in steps.
  [[nodiscard]] double best_lag(double from_s, double to_s, double step_s) const {
    double best_s = from_s, best = -1;
    const auto steps = static_cast<long>(std::floor((to_s - from_s) / step_s));
    for (long i = 0; i <= steps; ++i) {
      const double lag_s = from_s + static_cast<double>(i) * step_s;
      const double score = at(lag_s).score;
      if (score > best) best = score, best_s = lag_s;
    }
    return best_s;
  }

  [[nodiscard]] PairGuess guess(double lag_s) const {
    PairGuess result{.lag_s = lag_s};
    const Eigen::Quaterniond mean = at(lag_s).mean;
    result.T_a_b.linear() = mean.toRotationMatrix();
    std::array<std::vector<double>, 3> shifts;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < b_.views().size(); ++i) {
      const auto pose = a_.pose_at(b_.views()[i].time_s + lag_s);
      if (!pose) continue;
      ++seen;
      const Pose T_a_b = *pose * b_.poses()[i].inverse();
      if (mean.angularDistance(Eigen::Quaterniond(T_a_b.linear())) > kAgreeing) continue;
      ++result.agreeing;
      for (Eigen::Index k = 0; k < 3; ++k) shifts[static_cast<std::size_t>(k)].push_back(T_a_b.translation()[k]);
    }
    if (2 * result.agreeing < seen) result.agreeing = 0;  // by chance
    for (Eigen::Index k = 0; k < 3; ++k) {
      result.T_a_b.translation()[k] = median(std::move(shifts[static_cast<std::size_t>(k)]));
    }
    return result;
  }

 private:
  const BoardTrack& a_;
  const BoardTrack& b_;
};

}  // namespace

PairGuess guess_pair(const BoardTrack& a, const BoardTrack& b, Clocks clocks) {
  const Pair pair(a, b);
  if (clocks == Clocks::kShared) return pair.guess(0);
  const double first_s = a.views().front().time_s - b.views().back().time_s;
  const double last_s = a.views().back().time_s - b.views().front().time_s;
  const auto refined = [&](double lag_s) { return pair.best_lag(lag_s - kCoarse_s, lag_s + kCoarse_s, kFine_s); };
  const double any_s = refined(pair.best_lag(first_s, last_s, kCoarse_s));
  const double shared_s = pair.best_lag(-kNearlyShared_s, kNearlyShared_s, kFine_s);
  constexpr double kNearly = 0.9;
  const double zero = pair.at(0).score, shared = pair.at(shared_s).score, any = pair.at(any_s).score;
  if (std::max(zero, shared) < kNearly * any) {
    constexpr double kAside_s = 1, kAlike = 0.8;  // before a board at rest, all lags are alike: none is told
    const double aside = std::max(pair.at(any_s - kAside_s).score, pair.at(any_s + kAside_s).score);
    return aside < kAlike * any ? pair.guess(any_s) : PairGuess();
  }
  return pair.guess(zero >= kNearly * shared ? 0 : shared_s);
}

}  // namespace scanknit
