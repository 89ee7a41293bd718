// hull_box(): where the hull can be.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

#include "fusion/silhouette/hull_cubes.h"
#include "fusion/silhouette/visual_hull.h"

namespace scanknit {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr int kCells = 40;      // of the coarse grid, along an edge
constexpr int kMostLarger = 4;  // times that the grid is made twice as large

Error input_error(std::string message) {
  return {ErrorCode::kInput, std::move(message), "silhouettes"};
}

/// The ray through the middle of what a view shows.
Vector3d middle_ray(const SilhouetteView& view) {
  const Silhouette& seen = view.silhouette;
  return (view.T_world_camera.linear() * view.camera.unproject(seen.middle_u(), seen.middle_v(), 1)).normalized();
}

/// The point nearest to the rays through the middles, by least squares.
Result<Vector3d> common_middle(std::span<const SilhouetteView> views) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const SilhouetteView& view : views) {
    const Vector3d ray = middle_ray(view);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * view.T_world_camera.translation();
  }
  normal /= static_cast<double>(views.size());
  right /= static_cast<double>(views.size());
  constexpr double kLeastSpread = 1e-3;  // (sine of some two degrees)^2
  const double spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal).eigenvalues()[0];
  if (!(spread > kLeastSpread)) {
    return input_error("all views look in the same direction: silhouettes need pictures from several sides");
  }
  return Vector3d(normal.ldlt().solve(right));
}

/// How far the thing reaches from `middle` at most, judging by each view alone.
Result<double> largest_radius(std::span<const SilhouetteView> views, const Vector3d& middle) {
  double radius = 0;
  std::size_t behind = 0;
  for (const SilhouetteView& view : views) {
    const double z = (view.T_world_camera.inverse() * middle).z();
    if (!(z > 0)) {
      ++behind;
      continue;
    }
    const OutlineRect rect = *view.silhouette.bounds();
    const double half_px = std::hypot(rect.right - rect.left + 1, rect.bottom - rect.top + 1) / 2;
    radius = std::max(radius, half_px * z / focal_length(view.camera));
  }
  if (2 * behind > views.size()) {
    return input_error(
        "the cameras look away from one another: check that poses are camera-to-world with z forward and y down");
  }
  return radius;
}

struct CoarseHull {
  AlignedBox3d box;  ///< empty: there is none
  bool is_cut = false;
};

/// Of the cells of a grid in `box`.
CoarseHull coarse_hull(const HullCubes& cubes, const AlignedBox3d& box) {
  CoarseHull hull;
  const Vector3d cell = box.sizes() / kCells;
  const double half_m = cell.maxCoeff() / 2;
  for (int x = 0; x < kCells; ++x) {
    for (int y = 0; y < kCells; ++y) {
      for (int z = 0; z < kCells; ++z) {
        const Vector3d middle = box.min() + (Vector3d(x, y, z) + Vector3d::Constant(0.5)).cwiseProduct(cell);
        if (!cubes.is_seen(middle) || !cubes.may_hold_hull(middle, half_m)) continue;
        hull.box.extend(AlignedBox3d(middle - cell / 2, middle + cell / 2));
        const auto is_last = [](int i) { return i == 0 || i == kCells - 1; };
        hull.is_cut = hull.is_cut || is_last(x) || is_last(y) || is_last(z);
      }
    }
  }
  return hull;
}

AlignedBox3d enlarged(const AlignedBox3d& box, double times) {
  const Vector3d half = box.sizes() * (times / 2);
  return {box.center() - half, box.center() + half};
}

}  // namespace

Result<AlignedBox3d> hull_box(std::span<const SilhouetteView> views) {
  if (views.size() < 2) return input_error("a hull needs at least two pictures with a silhouette");
  const bool all_show_it = std::all_of(views.begin(), views.end(),
                                       [](const SilhouetteView& view) { return view.silhouette.bounds().has_value(); });
  if (!all_show_it) return input_error("a picture's mask is empty");
  const auto middle = common_middle(views);
  if (!middle) return middle.error();
  const auto radius = largest_radius(views, *middle);
  if (!radius) return radius.error();
  const HullCubes cubes(views);
  AlignedBox3d box(*middle - Vector3d::Constant(*radius), *middle + Vector3d::Constant(*radius));
  box = enlarged(box, 1.5);
  CoarseHull hull = coarse_hull(cubes, box);
  for (int k = 0; k < kMostLarger && hull.is_cut; ++k) {
    box = enlarged(box, 2);
    hull = coarse_hull(cubes, box);
  }
  if (!hull.box.isEmpty() && hull.is_cut) {
    return input_error("the views do not bound the thing on all sides: take pictures from more directions");
  }
  // In finer cells nothing may be left of what seemed to lie within all of them.
  if (!hull.box.isEmpty()) hull = coarse_hull(cubes, hull.box);
  if (hull.box.isEmpty()) {
    return input_error(
        "no point lies within all silhouettes: check the poses, the camera, and that no mask is inverted or of "
        "another picture");
  }
  return enlarged(hull.box, 1 + 2.0 / kCells);
}

}  // namespace scanknit
