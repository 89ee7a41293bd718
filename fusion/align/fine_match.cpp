#include "fusion/align/fine_match.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/median.h"
#include "fusion/register/motion_vector.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr std::size_t kMostPoints = 5000;   // of each scan in one round; more do not place it better
constexpr std::size_t kChunk = 128;         // points of a sum, whatever the number of threads
constexpr float kLeastNormalCosine = 0.7f;  // 45 degrees
constexpr double kTukey = 4.685;            // 95 % efficient for Gaussian noise
constexpr double kLeastScale = 0.02;        // of a spacing: residuals are not smaller but by chance
constexpr std::size_t kFewestPairs = 30;
constexpr double kConverged = 1e-4;  // of a spacing

/// Two points that are taken for the same, in scan b's frame.
struct PointPair {
  Vector3d own = Vector3d::Zero();    ///< of scan b
  Vector3d other = Vector3d::Zero();  ///< of scan a
  Vector3d normal = Vector3d::Zero();
  bool is_valid = false;
  [[nodiscard]] double residual() const { return normal.dot(own - other); }
};

/// Every point of `from` (thinned to kMostPoints) and its neighbour in `to`.
struct Side {
  const ScanLevel& from;
  const ScanLevel& to;
  Pose T_to_from;
};

template <typename Make>
void find_pairs(const Side& side, const Make& make, std::vector<PointPair>& pairs) {
  const std::size_t every = std::max<std::size_t>(1, (side.from.points.size() + kMostPoints - 1) / kMostPoints);
  const std::size_t count = (side.from.points.size() + every - 1) / every;
  const std::size_t first = pairs.size();
  pairs.resize(first + count);
  const Eigen::Isometry3f T = side.T_to_from.cast<float>();
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const std::size_t at = i * every;
    const Vector3f p = T * side.from.points.points_m[at];
    const Vector3f n = T.linear() * side.from.points.normals[at];
    const auto nearest = side.to.grid.nearest(
        p, [&](std::uint32_t candidate) { return n.dot(side.to.points.normals[candidate]) > kLeastNormalCosine; });
    if (nearest && side.to.points.is_rim[*nearest] == 0) pairs[first + i] = make(at, *nearest);
  });
}

std::vector<PointPair> all_pairs(const ScanLevel& a, const ScanLevel& b, const Pose& T_a_b) {
  const Pose T_b_a = T_a_b.inverse();
  const auto pair_of = [&](std::size_t in_a, std::size_t in_b) {
    const Vector3d normal_b = b.points.normals[in_b].cast<double>();
    const Vector3d normal_a = T_b_a.linear() * a.points.normals[in_a].cast<double>();
    return PointPair{b.points.points_m[in_b].cast<double>(), T_b_a * a.points.points_m[in_a].cast<double>(),
                     (normal_a + normal_b).normalized(), true};
  };
  std::vector<PointPair> pairs;
  find_pairs(
      {b, a, T_a_b}, [&](std::size_t own, std::size_t other) { return pair_of(other, own); }, pairs);
  find_pairs(
      {a, b, T_b_a}, [&](std::size_t own, std::size_t other) { return pair_of(own, other); }, pairs);
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [](const PointPair& pair) { return !pair.is_valid; }),
              pairs.end());
  return pairs;
}

struct NormalSums {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d vector = Vector6d::Zero();
  Vector3d points = Vector3d::Zero();
  double squares = 0, weight = 0, radii = 0;
  void add(const NormalSums& other) {
    matrix += other.matrix;
    vector += other.vector;
    points += other.points;
    squares += other.squares;
    weight += other.weight;
    radii += other.radii;
  }
};

double median_residual(const std::vector<PointPair>& pairs) {
  std::vector<double> sizes(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) sizes[i] = std::abs(pairs[i].residual());
  return median(std::move(sizes));
}

NormalSums sum_up(const std::vector<PointPair>& pairs, double reach) {
  std::vector<NormalSums> chunks((pairs.size() + kChunk - 1) / kChunk);
  tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t c) {
    NormalSums& sums = chunks[c];
    for (std::size_t i = c * kChunk; i < std::min((c + 1) * kChunk, pairs.size()); ++i) {
      const double residual = pairs[i].residual();
      const double ratio = residual / reach;
      if (std::abs(ratio) >= 1) continue;
      const double weight = (1 - ratio * ratio) * (1 - ratio * ratio);
      Vector6d row;
      row << pairs[i].normal, pairs[i].own.cross(pairs[i].normal);
      sums.matrix += weight * row * row.transpose();
      sums.vector -= weight * residual * row;
      sums.points += weight * pairs[i].own;
      sums.squares += weight * residual * residual;
      sums.radii += weight * pairs[i].own.squaredNorm();
      sums.weight += weight;
    }
  });
  NormalSums all;
  for (const NormalSums& chunk : chunks) all.add(chunk);
  return all;
}

Pose motion_of(const Vector6d& step) {
  Pose motion = Pose::Identity();
  const Vector3d turn = step.tail<3>();
  const double angle = turn.norm();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  motion.translation() = step.head<3>();
  return motion;
}

/// The normal equations with rotations about the middle of the points, in units of their radius.
struct CentredEquations {
  Matrix6d T_step = Matrix6d::Identity();  ///< step = T_step * centred step
  SymmetricModes modes;
  Vector6d vector = Vector6d::Zero();
  bool is_valid = false;  ///< the points do not all lie in one place
  [[nodiscard]] double least_strength() const { return is_valid ? std::max(0.0, modes.values[0]) : 0; }
};

CentredEquations centred(const NormalSums& sums) {
  CentredEquations equations;
  const Vector3d middle = sums.points / sums.weight;
  const double radius = std::sqrt(std::max(0.0, sums.radii / sums.weight - middle.squaredNorm()));
  if (!(radius > 0)) return equations;
  Matrix6d& T = equations.T_step;
  T.topRightCorner<3, 3>() = cross_matrix(middle);
  T.rightCols<3>() /= radius;
  Matrix6d matrix = Matrix6d::Zero();
  matrix.triangularView<Eigen::Lower>() = T.transpose() * (sums.matrix / sums.weight) * T;
  equations.modes = modes_of(matrix);
  equations.vector = T.transpose() * sums.vector / sums.weight;
  equations.is_valid = true;
  return equations;
}

/// The step along what is held firmly enough; `match` is told of the rest.
Vector6d held_step(const CentredEquations& equations, double least_moved, FineMatch& match) {
  if (!equations.is_valid) return Vector6d::Zero();
  Vector6d strengths = equations.modes.values;
  const Matrix6d& modes = equations.modes.vectors;
  Vector6d step = Vector6d::Zero();
  match.has_fixed_motion = false;
  for (Eigen::Index i = 0; i < 6; ++i) {
    if (strengths[i] >= least_moved) {
      step += modes.col(i) * (modes.col(i).dot(equations.vector) / strengths[i]);
    } else {
      strengths[i] = least_moved;
      match.has_fixed_motion = true;
    }
  }
  const Matrix6d back = modes.transpose() * equations.T_step.inverse();
  match.shape = back.transpose() * strengths.asDiagonal() * back;
  return equations.T_step * step;
}

/// What the scans do not hold is hardly moved.
Vector6d damped_step(const NormalSums& sums) {
  const Matrix6d damped =
      sums.matrix + 1e-6 * sums.weight * Matrix6d(sums.matrix.diagonal().asDiagonal()) / sums.weight;
  return Eigen::LDLT<Matrix6d>(damped).solve(sums.vector);
}

}  // namespace

ScanLevel::ScanLevel(OrientedPoints level_points, double spacing)
    : points(std::move(level_points)),
      spacing_m(spacing),
      grid(points.points_m, static_cast<float>(kReach * spacing)) {}

FineMatch match_finely(const ScanLevel& a, const ScanLevel& b, const Pose& T_a_b, int iterations, double least_moved) {
  FineMatch match{.T_a_b = T_a_b};
  for (int i = 0; i < iterations; ++i) {
    const std::vector<PointPair> pairs = all_pairs(a, b, match.T_a_b);
    match.pairs = pairs.size();
    if (pairs.size() < kFewestPairs) return FineMatch{.T_a_b = T_a_b};
    const double scale = std::max(1.4826 * median_residual(pairs), kLeastScale * a.spacing_m);
    const NormalSums sums = sum_up(pairs, kTukey * scale);
    match.shape = sums.matrix / sums.weight;
    match.residual_m = std::sqrt(sums.squares / sums.weight);
    const CentredEquations equations = centred(sums);
    match.least_strength = equations.least_strength();
    const Vector6d step = least_moved > 0 ? held_step(equations, least_moved, match) : damped_step(sums);
    if (!step.allFinite()) return FineMatch{.T_a_b = T_a_b};
    match.T_a_b = match.T_a_b * motion_of(step);
    const Vector3d middle = sums.points / sums.weight;
    const double moved =
        (motion_of(step) * middle - middle).norm() + step.tail<3>().norm() * std::sqrt(sums.radii / sums.weight);
    if (moved < kConverged * a.spacing_m) break;
  }
  Eigen::Quaterniond q(match.T_a_b.linear());  // rounding of many products
  match.T_a_b.linear() = q.normalized().toRotationMatrix();
  return match;
}

}  // namespace scanknit
