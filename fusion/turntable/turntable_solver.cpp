#include "fusion/turntable/turntable_solver.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "core/median.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using Matrix65d = Eigen::Matrix<double, 6, 5>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

constexpr int kAxis = 4;            // two tilts of the direction, two shifts of the point
constexpr int kGlobal = kAxis + 1;  // and the offset of the prior
constexpr int kMostIterations = 40;
constexpr double kUsualSigmas = 2.3;  // the median length of six normal numbers
constexpr double kLossSigmas = 4;     // of the usual: beyond this an edge is losing its say

/// The axis, moved by four small numbers in the plane across it.
TurntableAxis moved(const TurntableAxis& axis, const Eigen::Vector4d& by) {
  const Vector3d u = axis.direction.unitOrthogonal();
  const Vector3d v = axis.direction.cross(u);
  TurntableAxis result;
  result.direction = (axis.direction + by[0] * u + by[1] * v).normalized();
  result.point = axis.point + by[2] * u + by[3] * v;
  return result;
}

/// Where the motion leaves an edge: translation at its centre, then rotation, in the frame of `from`.
Vector6d error_of(const TurntableEdge& edge, const TurntableAxis& axis, double angle_rad) {
  const Pose error = turn_about(axis, angle_rad) * edge.T_from_to.inverse();
  const Eigen::AngleAxisd turn(error.linear());
  Vector6d e;
  e << error * edge.centre - edge.centre, turn.angle() * turn.axis();
  return e;
}

/// By the axis's four numbers and the difference of the angles; central differences.
Matrix65d derivative_of(const TurntableEdge& edge, const TurntableAxis& axis, double angle_rad) {
  constexpr double kStep = 1e-6;
  Matrix65d J;
  for (int i = 0; i < kAxis; ++i) {
    const Eigen::Vector4d step = kStep * Eigen::Vector4d::Unit(i);
    J.col(i) =
        (error_of(edge, moved(axis, step), angle_rad) - error_of(edge, moved(axis, -step), angle_rad)) / (2 * kStep);
  }
  J.col(kAxis) = (error_of(edge, axis, angle_rad + kStep) - error_of(edge, axis, angle_rad - kStep)) / (2 * kStep);
  return J;
}

class Problem {
 public:
  Problem(const TurntableMotion& start, const std::vector<TurntableEdge>& edges, const std::optional<AnglePrior>& prior)
      : edges_(edges), prior_(prior), state_{start, 0} {
    const std::size_t frames = start.angles_rad.size();
    SCANKNIT_CHECK(frames > 0 && (!prior || (prior->angles_rad.size() == frames && prior->sigma_rad > 0)));
    for (const TurntableEdge& edge : edges) SCANKNIT_CHECK(edge.from < frames && edge.to < frames);
    for (double& angle : state_.motion.angles_rad) angle -= start.angles_rad.front();
    if (prior) {
      std::vector<double> offsets;
      for (std::size_t i = 0; i < frames; ++i) offsets.push_back(state_.motion.angles_rad[i] - prior->angles_rad[i]);
      state_.offset_rad = median(offsets);
    }
  }

  TurntableSolution solve() {
    weigh();
    double lambda = 1e-6;
    double cost = cost_of(state_);
    int iterations = 0;
    for (; iterations < kMostIterations && lambda < 1e6; ++iterations) {
      const auto step = step_for(lambda);
      if (!step) {
        lambda *= 10;
        continue;
      }
      const State next = after(*step);
      const double next_cost = cost_of(next);
      if (!(next_cost <= cost)) {
        lambda *= 10;
        continue;
      }
      state_ = next;
      lambda = std::max(1e-9, lambda / 10);
      const bool has_settled = step->lpNorm<Eigen::Infinity>() < 1e-9;
      weigh();
      cost = cost_of(state_);
      if (has_settled) break;
    }
    return describe(iterations);
  }

 private:
  struct State {
    TurntableMotion motion;
    double offset_rad;  ///< angle = prior + offset
  };

  [[nodiscard]] double difference(const State& state, const TurntableEdge& edge) const {
    return state.motion.angles_rad[edge.to] - state.motion.angles_rad[edge.from];
  }
  [[nodiscard]] double squared_sigmas(const State& state, const TurntableEdge& edge) const {
    const Vector6d e = error_of(edge, state.motion.axis, difference(state, edge));
    return e.dot(edge.information * e);
  }

  /// Registration counts its points as if each were news; what is usual among the edges says how much they are.
  void weigh() {
    std::vector<double> sigmas;
    for (const TurntableEdge& edge : edges_) sigmas.push_back(std::sqrt(std::max(0.0, squared_sigmas(state_, edge))));
    scale_ = std::max(1.0, median(sigmas) / kUsualSigmas);
    weights_.clear();
    for (const double sigma : sigmas) {
      const double r = sigma / scale_ / (kLossSigmas * kUsualSigmas);
      weights_.push_back(1 / ((1 + r * r) * (1 + r * r)));
    }
  }

  [[nodiscard]] double cost_of(const State& state) const {
    double cost = 0;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      cost += weights_[i] * squared_sigmas(state, edges_[i]) / (scale_ * scale_);
    }
    if (!prior_) return cost;
    for (std::size_t i = 0; i < prior_->angles_rad.size(); ++i) {
      const double off = (state.motion.angles_rad[i] - prior_->angles_rad[i] - state.offset_rad) / prior_->sigma_rad;
      cost += off * off;
    }
    return cost;
  }

  /// Unknowns: the axis, the prior's offset, then the angles.
  [[nodiscard]] std::optional<Eigen::VectorXd> step_for(double lambda) const {
    const auto frames = static_cast<Eigen::Index>(state_.motion.angles_rad.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd downhill = Eigen::VectorXd::Zero(kGlobal + frames);
    const auto add = [&](Eigen::Index row, Eigen::Index column, double value) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
    };
    for (std::size_t i = 0; i < edges_.size(); ++i) add_edge(i, add, downhill);
    if (prior_) add_prior(add, downhill);
    constexpr double kHeld = 1e12;   // the first angle is 0
    constexpr double kLoose = 1e-3;  // what nothing holds stays
    add(kGlobal, kGlobal, kHeld);
    for (Eigen::Index i = 0; i < kGlobal + frames; ++i) add(i, i, kLoose);
    Eigen::SparseMatrix<double> H(kGlobal + frames, kGlobal + frames);
    H.setFromTriplets(entries.begin(), entries.end());
    for (Eigen::Index i = 0; i < kGlobal + frames; ++i) H.coeffRef(i, i) *= 1 + lambda;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(H);
    if (factors.info() != Eigen::Success) return std::nullopt;
    Eigen::VectorXd step = factors.solve(downhill);
    if (!step.allFinite()) return std::nullopt;
    return step;
  }

  template <typename Add>
  void add_edge(std::size_t i, const Add& add, Eigen::VectorXd& downhill) const {
    const TurntableEdge& edge = edges_[i];
    const double angle = difference(state_, edge);
    const Matrix65d J = derivative_of(edge, state_.motion.axis, angle);
    const Matrix6d information = weights_[i] / (scale_ * scale_) * edge.information;
    const Matrix5d H = J.transpose() * information * J;
    const Vector5d b = -J.transpose() * information * error_of(edge, state_.motion.axis, angle);
    const auto from = kGlobal + static_cast<Eigen::Index>(edge.from);
    const auto to = kGlobal + static_cast<Eigen::Index>(edge.to);
    for (int row = 0; row < kAxis; ++row) {
      for (int column = 0; column < kAxis; ++column) add(row, column, H(row, column));
      for (const auto& [angle_index, sign] : {std::pair(from, -1.0), std::pair(to, 1.0)}) {
        add(row, angle_index, sign * H(row, kAxis));
        add(angle_index, row, sign * H(row, kAxis));
      }
      downhill[row] += b[row];
    }
    const double h = H(kAxis, kAxis);
    add(from, from, h);
    add(to, to, h);
    add(from, to, -h);
    add(to, from, -h);
    downhill[from] -= b[kAxis];
    downhill[to] += b[kAxis];
  }

  template <typename Add>
  void add_prior(const Add& add, Eigen::VectorXd& downhill) const {
    const double weight = 1 / (prior_->sigma_rad * prior_->sigma_rad);
    for (std::size_t i = 0; i < prior_->angles_rad.size(); ++i) {
      const auto angle = kGlobal + static_cast<Eigen::Index>(i);
      const double off = state_.motion.angles_rad[i] - prior_->angles_rad[i] - state_.offset_rad;
      add(angle, angle, weight);
      add(kAxis, kAxis, weight);
      add(angle, kAxis, -weight);
      add(kAxis, angle, -weight);
      downhill[angle] -= weight * off;
      downhill[kAxis] += weight * off;
    }
  }

  [[nodiscard]] State after(const Eigen::VectorXd& step) const {
    State next = state_;
    next.motion.axis = moved(state_.motion.axis, step.head<kAxis>());
    next.offset_rad += step[kAxis];
    for (std::size_t i = 1; i < next.motion.angles_rad.size(); ++i) {
      next.motion.angles_rad[i] += step[kGlobal + static_cast<Eigen::Index>(i)];
    }
    return next;
  }

  [[nodiscard]] TurntableSolution describe(int iterations) const {
    TurntableSolution solution;
    solution.motion = state_.motion;
    solution.iterations = iterations;
    double weights = 0;
    std::vector<double> angle_sigmas;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const double angle = difference(state_, edges_[i]);
      const Vector6d e = error_of(edges_[i], state_.motion.axis, angle);
      const Vector6d by_angle = derivative_of(edges_[i], state_.motion.axis, angle).col(kAxis);
      solution.sigmas.push_back(std::sqrt(std::max(0.0, e.dot(edges_[i].information * e))) / (scale_ * kUsualSigmas));
      solution.weights.push_back(weights_[i]);
      solution.rms_m += weights_[i] * e.head<3>().squaredNorm();
      solution.rms_rad += weights_[i] * e.tail<3>().squaredNorm();
      weights += weights_[i];
      const double held = by_angle.dot(edges_[i].information * by_angle) / (scale_ * scale_);
      angle_sigmas.push_back(held > 0 ? 1 / std::sqrt(held) : std::numeric_limits<double>::infinity());
    }
    if (weights > 0) solution.rms_m = std::sqrt(solution.rms_m / weights);
    if (weights > 0) solution.rms_rad = std::sqrt(solution.rms_rad / weights);
    solution.angle_sigma_rad = median(angle_sigmas);
    return solution;
  }

  const std::vector<TurntableEdge>& edges_;
  const std::optional<AnglePrior>& prior_;
  State state_;
  double scale_ = 1;
  std::vector<double> weights_;
};

}  // namespace

TurntableSolution solve_turntable(const TurntableMotion& start, const std::vector<TurntableEdge>& edges,
                                  const std::optional<AnglePrior>& prior) {
  return Problem(start, edges, prior).solve();
}

}  // namespace scanknit
