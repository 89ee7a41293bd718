#include "fusion/loops/pose_graph.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace scanknit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kUnknowns = 6;  // of a node
constexpr int kMostIterations = 60;
constexpr double kSettled = 1e-9;  // m and rad

Vector3d rotation_vector(const Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Matrix3d rotation_of(const Vector3d& vector) {
  const double angle = vector.norm();
  if (!(angle > 0)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

/// How a rotation vector changes when its rotation is turned a little further (Chirikjian 2011).
Matrix3d right_jacobian_inverse(const Vector3d& vector) {
  const double angle = vector.norm();
  const Matrix3d cross = cross_matrix(vector);
  const double share = angle < 1e-4 ? 1.0 / 12 : 1 / (angle * angle) - 0.5 / (angle * std::tan(angle / 2));
  return Matrix3d::Identity() + 0.5 * cross + share * cross * cross;
}

Vector6d error_of(const PoseEdge& edge, const Pose& T_world_from, const Pose& T_world_to) {
  const Pose T_measured_found = edge.T_from_to.inverse() * (T_world_from.inverse() * T_world_to);
  Vector6d error;
  error << T_measured_found.translation(), rotation_vector(T_measured_found.linear());
  return error;
}

/// The error, and its derivatives by small motions of both nodes: T * (translation, rotation vector).
struct Linearised {
  Vector6d error;
  Matrix6d by_from = Matrix6d::Zero(), by_to = Matrix6d::Zero();
};

Linearised linearise(const PoseEdge& edge, const Pose& T_world_from, const Pose& T_world_to) {
  Linearised line;
  line.error = error_of(edge, T_world_from, T_world_to);
  const Pose T_from_to = T_world_from.inverse() * T_world_to;
  const Matrix3d R_measured_from = edge.T_from_to.linear().transpose();
  const Matrix3d J = right_jacobian_inverse(line.error.tail<3>());
  line.by_to.topLeftCorner<3, 3>() = R_measured_from * T_from_to.linear();
  line.by_to.bottomRightCorner<3, 3>() = J;
  line.by_from.topLeftCorner<3, 3>() = -R_measured_from;
  line.by_from.topRightCorner<3, 3>() = R_measured_from * cross_matrix(T_from_to.translation());
  line.by_from.bottomRightCorner<3, 3>() = -J * T_from_to.linear().transpose();
  return line;
}

class Optimiser {
 public:
  Optimiser(std::vector<Pose>& poses, const std::vector<PoseEdge>& edges, double loss_sigmas)
      : poses_(poses), edges_(edges), square_of_loss_(loss_sigmas * loss_sigmas), weights_(edges.size(), 1.0) {}

  PoseGraphResult run() {
    PoseGraphResult result;
    double convexity = first_convexity();
    while (result.iterations < kMostIterations && !result.has_converged) {
      weigh(convexity);
      const double step = improve();
      ++result.iterations;
      if (step < kSettled && convexity <= 1) result.has_converged = true;
      if (step < 1e-4 || result.iterations % 4 == 0) convexity = std::max(1.0, convexity / 1.6);
    }
    weigh(1);
    result.weights = weights_;
    for (const PoseEdge& edge : edges_) result.sigmas.push_back(std::sqrt(square_of(edge)));
    return result;
  }

 private:
  [[nodiscard]] double square_of(const PoseEdge& edge) const {
    const double sigmas = edge_sigmas(edge, poses_[edge.from], poses_[edge.to]);
    return sigmas * sigmas;
  }

  /// So wide a loss that all edges count.
  [[nodiscard]] double first_convexity() const {
    double farthest = 0;
    for (const PoseEdge& edge : edges_) {
      if (edge.may_be_wrong) farthest = std::max(farthest, square_of(edge));
    }
    return std::clamp(2 * farthest / square_of_loss_, 1.0, 1e6);
  }

  void weigh(double convexity) {
    const double scale = convexity * square_of_loss_;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      if (!edges_[i].may_be_wrong) continue;
      const double weight = scale / (scale + square_of(edges_[i]));
      weights_[i] = weight * weight;
    }
  }

  /// Of the weighted squares, for the weights as they are.
  [[nodiscard]] double cost() const {
    double sum = 0;
    for (std::size_t i = 0; i < edges_.size(); ++i) sum += weights_[i] * square_of(edges_[i]);
    return sum;
  }

  /// One step downhill. Returns its largest entry; 0 when there is no way down.
  double improve() {
    const auto size = static_cast<Eigen::Index>(kUnknowns * poses_.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd slope = Eigen::VectorXd::Zero(size);
    for (std::size_t i = 0; i < edges_.size(); ++i) add_edge(edges_[i], weights_[i], entries, slope);
    Eigen::SparseMatrix<double> hessian(size, size);
    const double before = cost();
    for (int tries = 0; tries < 12; ++tries) {
      auto damped = entries;
      for (Eigen::Index k = 0; k < size; ++k) damped.emplace_back(k, k, k < kUnknowns ? 1.0 : damping_);
      hessian.setFromTriplets(damped.begin(), damped.end());
      const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(hessian);
      if (solver.info() == Eigen::Success) {
        const Eigen::VectorXd step = solver.solve(-slope);
        const std::vector<Pose> kept = poses_;
        move(step);
        if (step.allFinite() && cost() <= before) {
          damping_ = std::max(damping_ * 0.2, 1e-9);
          return step.lpNorm<Eigen::Infinity>();
        }
        poses_ = kept;
      }
      damping_ *= 10;
    }
    damping_ = kFirstDamping;
    return 0;
  }

  void add_edge(const PoseEdge& edge, double weight, std::vector<Eigen::Triplet<double>>& entries,
                Eigen::VectorXd& slope) const {
    const Linearised line = linearise(edge, poses_[edge.from], poses_[edge.to]);
    const Matrix6d information = weight * edge.information;
    const auto add_block = [&](std::size_t row, std::size_t column, const Matrix6d& block) {
      if (row == 0 || column == 0) return;  // the first node stays
      for (int r = 0; r < kUnknowns; ++r) {
        for (int c = 0; c < kUnknowns; ++c) {
          entries.emplace_back(static_cast<int>(row) * kUnknowns + r, static_cast<int>(column) * kUnknowns + c,
                               block(r, c));
        }
      }
    };
    const auto add_slope = [&](std::size_t node, const Vector6d& part) {
      if (node > 0) slope.segment<kUnknowns>(static_cast<Eigen::Index>(node) * kUnknowns) += part;
    };
    add_block(edge.from, edge.from, line.by_from.transpose() * information * line.by_from);
    add_block(edge.to, edge.to, line.by_to.transpose() * information * line.by_to);
    add_block(edge.from, edge.to, line.by_from.transpose() * information * line.by_to);
    add_block(edge.to, edge.from, line.by_to.transpose() * information * line.by_from);
    add_slope(edge.from, line.by_from.transpose() * information * line.error);
    add_slope(edge.to, line.by_to.transpose() * information * line.error);
  }

  void move(const Eigen::VectorXd& step) {
    for (std::size_t node = 1; node < poses_.size(); ++node) {
      const Vector6d motion = step.segment<kUnknowns>(static_cast<Eigen::Index>(node) * kUnknowns);
      Pose& pose = poses_[node];
      pose.translation() += pose.linear() * motion.head<3>();
      pose.linear() = Eigen::Quaterniond(pose.linear() * rotation_of(motion.tail<3>())).normalized().toRotationMatrix();
    }
  }

  static constexpr double kFirstDamping = 1e-6;

  std::vector<Pose>& poses_;
  const std::vector<PoseEdge>& edges_;
  double square_of_loss_;
  std::vector<double> weights_;
  double damping_ = kFirstDamping;
};

}  // namespace

double edge_sigmas(const PoseEdge& edge, const Pose& T_world_from, const Pose& T_world_to) {
  const Vector6d error = error_of(edge, T_world_from, T_world_to);
  return std::sqrt(std::max(0.0, error.dot(edge.information * error)));
}

PoseGraphResult optimise_poses(std::vector<Pose>& T_world_nodes, const std::vector<PoseEdge>& edges,
                               double loss_sigmas) {
  for (const PoseEdge& edge : edges) {
    SCANKNIT_CHECK(edge.from < T_world_nodes.size() && edge.to < T_world_nodes.size() && edge.from != edge.to);
  }
  return Optimiser(T_world_nodes, edges, loss_sigmas).run();
}

}  // namespace scanknit
