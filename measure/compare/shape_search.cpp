#include "measure/compare/shape_search.h"

#include <tbb/parallel_invoke.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "measure/area_points.h"
#include "measure/compare/fit_meshes.h"
#include "measure/compare/signed_distance.h"
#include "measure/turns.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kCoarsePoints = 400, kFinePoints = 3000;
constexpr std::size_t kKept = 8;  // placements that are improved

/// The frame of the principal axes about the centre of points.
Pose principal_frame(const std::vector<Vector3d>& points) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : points) centre += p / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - centre) * (p - centre).transpose();
  Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  Pose T_world_frame = Pose::Identity();
  T_world_frame.linear() = axes;
  T_world_frame.translation() = centre;
  return T_world_frame;
}

double radius_of(const std::vector<Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return box.diagonal().norm() / 2;
}

/// The mean distance of points from a surface, those beyond `most_m` counted as so far.
double mean_distance(const std::vector<Vector3d>& points, const Pose& T_surface_points, const SignedDistance& surface,
                     double most_m) {
  std::vector<Vector3d> moved;
  moved.reserve(points.size());
  for (const Vector3d& p : points) moved.push_back(T_surface_points * p);
  double sum = 0;
  for (const double d : surface.at(moved)) sum += std::min(std::abs(d), most_m);
  return sum / static_cast<double>(points.size());
}

struct Candidate {
  Pose T_reference_mesh;
  double misfit = 0;
};

}  // namespace

ShapePlacement find_by_shape(const Mesh& mesh, const Mesh& reference) {
  std::optional<SignedDistance> from_mesh, from_reference;
  tbb::parallel_invoke([&] { from_mesh.emplace(mesh); }, [&] { from_reference.emplace(reference); });
  const auto points_of = [](const Mesh& of, std::size_t count) { return positions_of(spread_over_area(of, count)); };
  const std::vector<Vector3d> mesh_fine = points_of(mesh, kFinePoints),
                              reference_fine = points_of(reference, kFinePoints);
  const std::vector<Vector3d> mesh_coarse = points_of(mesh, kCoarsePoints);
  const std::vector<Vector3d> reference_coarse = points_of(reference, kCoarsePoints);
  const double most_m = radius_of(reference_fine) / 5;
  const auto misfit = [&](const Pose& T_reference_mesh, bool is_fine) {
    return mean_distance(is_fine ? mesh_fine : mesh_coarse, T_reference_mesh, *from_reference, most_m) +
           mean_distance(is_fine ? reference_fine : reference_coarse, T_reference_mesh.inverse(), *from_mesh, most_m);
  };
  const auto sort_by_misfit = [](std::vector<Candidate>& list) {
    std::stable_sort(list.begin(), list.end(),
                     [](const Candidate& a, const Candidate& b) { return a.misfit < b.misfit; });
  };

  const Pose T_mesh_axes = principal_frame(mesh_fine), T_reference_axes = principal_frame(reference_fine);
  std::vector<Candidate> candidates;
  for (const Eigen::Quaterniond& turn : icosahedral_rotations()) {
    const Pose start = T_reference_axes * Pose(turn) * T_mesh_axes.inverse();
    const Pose fitted = fit_points(mesh_coarse, *from_reference, start, {.rounds = 12, .least_step = 1e-3});
    candidates.push_back({fitted, misfit(fitted, false)});
  }
  sort_by_misfit(candidates);
  candidates.resize(std::min(candidates.size(), kKept));
  for (Candidate& candidate : candidates) {
    candidate.T_reference_mesh =
        fit_points(mesh_fine, *from_reference, candidate.T_reference_mesh, {.rounds = 30, .least_step = 1e-5});
    candidate.misfit = misfit(candidate.T_reference_mesh, true);
  }
  sort_by_misfit(candidates);
  const Candidate& best = candidates.front();
  constexpr double kOtherTurn = 10 * std::numbers::pi / 180, kAsWell = 1.1;
  const bool is_ambiguous = std::any_of(candidates.begin() + 1, candidates.end(), [&](const Candidate& other) {
    const Eigen::Matrix3d between = best.T_reference_mesh.linear().transpose() * other.T_reference_mesh.linear();
    return Eigen::AngleAxisd(between).angle() > kOtherTurn && other.misfit <= kAsWell * best.misfit + 1e-9 * most_m;
  });
  return {best.T_reference_mesh, is_ambiguous};
}

}  // namespace scanknit
