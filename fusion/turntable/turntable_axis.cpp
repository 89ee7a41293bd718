#include "fusion/turntable/turntable_axis.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/median.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastTurn_rad = 20 * kDegree;
constexpr int kRounds = 8;

/// A relative motion between two cameras that is long enough to show the axis.
struct Screw {
  Pose T_from_to;
  Vector3d axis;  ///< unit
  double angle_rad;
  double weight = 1;
};

/// Pairs at several distances in time, so that slow and quick turns, few and many frames all show their axis.
std::vector<Screw> screws_of(const std::vector<Pose>& poses) {
  std::vector<Screw> screws;
  for (std::size_t stride = 1; stride < poses.size(); stride *= 2) {
    for (std::size_t i = 0; i + stride < poses.size(); ++i) {
      const Pose motion = poses[i].inverse() * poses[i + stride];
      const Eigen::AngleAxisd turn(motion.linear());
      if (turn.angle() < kLeastTurn_rad || turn.angle() > 160 * kDegree) continue;
      screws.push_back({motion, turn.axis(), turn.angle()});
    }
  }
  return screws;
}

/// Cauchy's weights for residuals, relative to their median, which is not taken below `least`.
void weigh(const std::vector<double>& residuals, double least, std::vector<Screw>& screws) {
  const double scale = 2 * std::max(median(residuals), least);
  for (std::size_t i = 0; i < screws.size(); ++i) {
    const double r = residuals[i] / scale;
    screws[i].weight = 1 / (1 + r * r);
  }
}

/// The axis that most screws share, up to its sign.
Vector3d common_direction(std::vector<Screw>& screws) {
  Vector3d direction = Vector3d::UnitY();
  std::vector<double> residuals(screws.size());
  for (int round = 0; round < kRounds; ++round) {
    Matrix3d scatter = Matrix3d::Zero();
    for (const Screw& screw : screws) {
      const double half_sine = std::sin(screw.angle_rad / 2);
      scatter += screw.weight * half_sine * half_sine * screw.axis * screw.axis.transpose();
    }
    direction = Eigen::SelfAdjointEigenSolver<Matrix3d>(scatter).eigenvectors().col(2);
    for (std::size_t i = 0; i < screws.size(); ++i) {
      residuals[i] = screws[i].axis.cross(direction).norm() * std::sin(screws[i].angle_rad / 2);
    }
    weigh(residuals, 1e-6, screws);
  }
  return direction;
}

/// (I - R) c = t for all screws at once; of the solutions, the one nearest to the camera.
Vector3d common_point(const Vector3d& direction, std::vector<Screw>& screws) {
  Vector3d point = Vector3d::Zero();
  std::vector<double> residuals(screws.size());
  for (Screw& screw : screws) screw.weight = 1;
  for (int round = 0; round < kRounds; ++round) {
    Matrix3d A = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const Screw& screw : screws) {
      const Matrix3d M = Matrix3d::Identity() - screw.T_from_to.linear();
      A += screw.weight * M.transpose() * M;
      b += screw.weight * M.transpose() * screw.T_from_to.translation();
    }
    A += A.trace() * direction * direction.transpose();
    point = A.inverse() * b;
    for (std::size_t i = 0; i < screws.size(); ++i) {
      const Vector3d off = screws[i].T_from_to * point - point;
      residuals[i] = (off - direction * direction.dot(off)).norm();
    }
    weigh(residuals, 1e-6, screws);
  }
  return point - direction * direction.dot(point);
}

}  // namespace

double angle_about(const Vector3d& direction, const Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return 2 * std::atan2(q.vec().dot(direction), q.w());
}

double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

double usual_step_rad(const TurntableMotion& motion) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < motion.angles_rad.size(); ++i) {
    steps.push_back(motion.angles_rad[i] - motion.angles_rad[i - 1]);
  }
  return median(steps);
}

Pose turn_about(const TurntableAxis& axis, double angle_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle_rad, axis.direction).toRotationMatrix();
  pose.translation() = axis.point - pose.linear() * axis.point;
  return pose;
}

std::optional<TurntableMotion> fit_turntable(const std::vector<Pose>& T_object_camera, double reach_m) {
  std::vector<Screw> screws = screws_of(T_object_camera);
  if (screws.empty()) return std::nullopt;
  TurntableMotion motion;
  motion.axis.direction = common_direction(screws);
  motion.axis.point = common_point(motion.axis.direction, screws);
  // The point of the axis that is nearest to what the camera looks at.
  const Vector3d looked_at(0, 0, reach_m);
  motion.axis.point += motion.axis.direction * motion.axis.direction.dot(looked_at - motion.axis.point);
  double angle = 0;
  for (std::size_t i = 0; i < T_object_camera.size(); ++i) {
    if (i > 0) {
      const Pose step = T_object_camera[i - 1].inverse() * T_object_camera[i];
      angle += wrapped(angle_about(motion.axis.direction, step.linear()));
      // Steps add up what each has of noise; the whole turn since the first pose does not.
      const Matrix3d whole = T_object_camera.front().linear().transpose() * T_object_camera[i].linear();
      angle += wrapped(angle_about(motion.axis.direction, whole) - angle);
    }
    motion.angles_rad.push_back(angle);
  }
  if (motion.angles_rad.back() < 0) {  // the angles grow
    motion.axis.direction = -motion.axis.direction;
    for (double& value : motion.angles_rad) value = -value;
  }
  return motion;
}

std::vector<double> distances_from(const TurntableMotion& motion, const std::vector<Pose>& T_object_camera,
                                   double reach_m) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < T_object_camera.size(); ++i) {
    const Pose seen = T_object_camera.front().inverse() * T_object_camera[i];
    const Pose apart = turn_about(motion.axis, motion.angles_rad[i]).inverse() * seen;
    const double moved = (apart * motion.axis.point - motion.axis.point).norm();
    distances.push_back(moved + 0.1 * reach_m * Eigen::AngleAxisd(apart.linear()).angle());
  }
  return distances;
}

}  // namespace scanknit
