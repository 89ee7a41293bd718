#include "synth/surface_error.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measure/area_points.h"
#include "measure/tree/triangle_bvh.h"
#include "synth/truth_files.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

DistanceStats stats_of(std::vector<double> distances_m) {
  DistanceStats stats;
  stats.count = distances_m.size();
  if (distances_m.empty()) return stats;
  std::sort(distances_m.begin(), distances_m.end());
  const auto n = static_cast<double>(distances_m.size());
  double sum = 0;
  double sum_of_squares = 0;
  for (const double d : distances_m) {
    sum += d;
    sum_of_squares += d * d;
  }
  const auto quantile = [&](double q) { return distances_m[static_cast<std::size_t>(q * (n - 1))]; };
  const auto share_within = [&](double limit_m) {
    const auto end = std::upper_bound(distances_m.begin(), distances_m.end(), limit_m);
    return static_cast<double>(end - distances_m.begin()) / n;
  };
  stats.mean_m = sum / n;
  stats.rms_m = std::sqrt(sum_of_squares / n);
  stats.median_m = quantile(0.5);
  stats.p95_m = quantile(0.95);
  stats.max_m = distances_m.back();
  stats.share_within_1mm = share_within(0.001);
  stats.share_within_5mm = share_within(0.005);
  return stats;
}

/// The distances of `count` points, in order.
template <typename DistanceOf>
std::vector<double> measure(std::size_t count, const DistanceOf& distance_of) {
  std::vector<double> distances_m(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { distances_m[i] = distance_of(i); });
  return distances_m;
}

}  // namespace

Pose fit_to_surface(const Mesh& mesh, const SyntheticScene& scene, const Pose& start) {
  constexpr int kRounds = 10;
  constexpr std::size_t kMostPoints = 20'000;
  constexpr double kLoss_m = 0.002;  // points farther away get less weight
  const std::size_t stride = mesh.positions_m.size() / kMostPoints + 1;
  Pose T_truth_mesh = start;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t count = (mesh.positions_m.size() + stride - 1) / stride;
    std::vector<SurfacePoint> feet(count);
    const auto at = [&](std::size_t i) { return T_truth_mesh * mesh.positions_m[i * stride].cast<double>(); };
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { feet[i] = scene.nearest(at(i)); });
    Eigen::Matrix<double, 6, 6> A = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t i = 0; i < count; ++i) {
      const Vector3d p = at(i);
      Eigen::Matrix<double, 6, 1> J;
      J << feet[i].normal, p.cross(feet[i].normal);
      const double r = feet[i].normal.dot(p - feet[i].position);
      const double weight = 1 / (1 + (r / kLoss_m) * (r / kLoss_m));
      A += weight * J * J.transpose();
      b -= weight * r * J;
    }
    const Eigen::Matrix<double, 6, 1> step = A.ldlt().solve(b);
    const double angle = step.tail<3>().norm();
    Pose moved = Pose::Identity();
    if (angle > 0) moved.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix();
    moved.translation() = step.head<3>();
    T_truth_mesh = moved * T_truth_mesh;
  }
  return T_truth_mesh;
}

Result<SurfaceError> measure_surface(const Mesh& mesh, const SyntheticScene& scene,
                                     const std::vector<TruthPoint>& visible, const SurfaceErrorConfig& config) {
  if (auto measurable = check_measurable(mesh); !measurable) return measurable.error();
  const std::vector<Vector3d> samples = positions_of(spread_over_area(mesh, config.area_samples));

  SurfaceError error;
  error.threshold_m = config.threshold_m;
  error.vertices = stats_of(measure(mesh.positions_m.size(), [&](std::size_t i) {
    return scene.surface_distance(mesh.positions_m[i].cast<double>());
  }));
  error.area = stats_of(measure(samples.size(), [&](std::size_t i) { return scene.surface_distance(samples[i]); }));

  const TriangleBvh bvh(mesh);
  std::vector<double> to_mesh = measure(visible.size(), [&](std::size_t i) {
    const auto foot = bvh.nearest(visible[i].position_m.cast<double>(), std::numeric_limits<double>::infinity());
    return foot ? foot->distance_m : std::numeric_limits<double>::infinity();
  });
  const auto complete =
      std::count_if(to_mesh.begin(), to_mesh.end(), [&](double d) { return d <= config.threshold_m; });
  error.share_complete = visible.empty() ? 0 : static_cast<double>(complete) / static_cast<double>(visible.size());
  error.completeness = stats_of(std::move(to_mesh));
  return error;
}

Result<SurfaceError> measure_surface(const Mesh& mesh, const std::filesystem::path& truth_folder,
                                     const SurfaceErrorConfig& config) {
  const auto truth = read_truth(truth_folder);
  if (!truth) return truth.error();
  return measure_surface(mesh, *truth->scene, truth->visible, config);
}

}  // namespace scanknit
