#include "measure/compare/fit_meshes.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace scanknit {
namespace {

using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct PlaneFoot {
  Vector3d position, normal;
};

std::vector<PlaneFoot> feet_of(const std::vector<Vector3d>& points, const SignedDistance& reference,
                               const Pose& T_reference_mesh) {
  std::vector<PlaneFoot> feet(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const auto foot = reference.tree().nearest(T_reference_mesh * points[i], std::numeric_limits<double>::infinity());
    feet[i] = {foot->position, reference.normals().face(foot->triangle)};
  });
  return feet;
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Translation, then rotation, both about `centre`.
Pose motion_of(const Vector6& step, const Vector3d& centre) {
  Pose motion = Pose::Identity();
  const double angle = step.tail<3>().norm();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix();
  motion.translation() = centre + step.head<3>() - motion.linear() * centre;
  return motion;
}

}  // namespace

Pose fit_points(const std::vector<Vector3d>& points, const SignedDistance& reference, const Pose& start,
                const FitConfig& config) {
  Pose T_reference_mesh = start;
  if (points.empty()) return start;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  double spread = 0;
  for (const Vector3d& p : points) spread = std::max(spread, (p - mean).norm());
  if (!(spread > 0)) return start;
  for (int round = 0; round < config.rounds; ++round) {
    const std::vector<PlaneFoot> feet = feet_of(points, reference, T_reference_mesh);
    const Vector3d centre = T_reference_mesh * mean;
    std::vector<double> sizes(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) sizes[i] = (T_reference_mesh * points[i] - feet[i].position).norm();
    const double scale = std::max(2 * median_of(sizes), 1e-9 * spread);
    Matrix6 A = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d p = T_reference_mesh * points[i];
      Vector6 J;  // rotations in units of the spread, so that all six numbers are lengths
      J << feet[i].normal, (p - centre).cross(feet[i].normal) / spread;
      const double weight = 1 / (1 + (sizes[i] / scale) * (sizes[i] / scale));
      A += weight * J * J.transpose();
      b -= weight * feet[i].normal.dot(p - feet[i].position) * J;
    }
    A += 1e-6 * A.trace() * Matrix6::Identity();
    Vector6 step = A.ldlt().solve(b);
    if (!step.allFinite()) return T_reference_mesh;
    const double size = step.norm();
    step.tail<3>() /= spread;
    T_reference_mesh = motion_of(step, centre) * T_reference_mesh;
    if (size <= config.least_step * spread) break;
  }
  T_reference_mesh.linear() = Eigen::Quaterniond(T_reference_mesh.linear()).normalized().toRotationMatrix();
  return T_reference_mesh;
}

}  // namespace scanknit
