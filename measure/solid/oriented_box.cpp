#include "measure/solid/oriented_box.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "core/check.h"
#include "measure/turns.h"

namespace scanknit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kDirections = 256;

std::vector<std::uint32_t> used_vertices(const Mesh& mesh) {
  std::vector<bool> is_used(mesh.positions_m.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) is_used[v] = true;
  }
  std::vector<std::uint32_t> used;
  for (std::uint32_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v]) used.push_back(v);
  }
  return used;
}

/// The farthest points in directions all around (a Fibonacci lattice on the sphere).
std::vector<Vector3d> extreme_points(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  std::vector<std::uint32_t> farthest(kDirections);
  tbb::parallel_for(0, kDirections, [&](int i) {
    const double z = 1 - (2 * i + 1.0) / kDirections;
    const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
    const double radius = std::sqrt(1 - z * z);
    const Eigen::Vector3f direction = Vector3d(radius * std::cos(angle), radius * std::sin(angle), z).cast<float>();
    std::uint32_t best = vertices.front();
    float best_along = mesh.positions_m[best].dot(direction);
    for (const std::uint32_t v : vertices) {
      const float along = mesh.positions_m[v].dot(direction);
      if (along > best_along) std::tie(best, best_along) = std::pair(v, along);
    }
    farthest[static_cast<std::size_t>(i)] = best;
  });
  std::sort(farthest.begin(), farthest.end());
  farthest.erase(std::unique(farthest.begin(), farthest.end()), farthest.end());
  std::vector<Vector3d> points;
  for (const std::uint32_t v : farthest) points.push_back(mesh.positions_m[v].cast<double>());
  return points;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The convex hull, counter-clockwise (Andrew 1979, monotone chain).
std::vector<Vector2d> hull_of(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  std::vector<Vector2d> hull;
  for (const bool is_upper : {false, true}) {
    const std::size_t begin = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= begin + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    if (!is_upper) std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// The direction along which the smallest rectangle round the points lies: that of a side of their hull.
Vector2d smallest_rectangle(const std::vector<Vector2d>& points) {
  const std::vector<Vector2d> hull = hull_of(points);
  Vector2d best = Vector2d::UnitX();
  double least_area = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d side = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    if (!(side.norm() > 0.5)) continue;
    Eigen::AlignedBox2d box;
    for (const Vector2d& p : hull) box.extend(Vector2d(side.dot(p), cross(side, p)));
    const double area = box.sizes().prod();
    if (area < least_area) std::tie(best, least_area) = std::pair(side, area);
  }
  return best;
}

Vector3d size_along(const std::vector<Vector3d>& points, const Eigen::Matrix3d& axes) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(axes.transpose() * p);
  return box.sizes();
}

/// Turns the axes about each of them in turn as long as that makes the box smaller.
Eigen::Matrix3d shrink_box(const std::vector<Vector3d>& points, Eigen::Matrix3d axes) {
  constexpr int kMostRounds = 20;
  double volume = size_along(points, axes).prod();
  for (int round = 0; round < kMostRounds; ++round) {
    const double before = volume;
    for (int about = 0; about < 3; ++about) {
      const Vector3d u = axes.col((about + 1) % 3), v = axes.col((about + 2) % 3);
      std::vector<Vector2d> flat;
      flat.reserve(points.size());
      for (const Vector3d& p : points) flat.emplace_back(u.dot(p), v.dot(p));
      const Vector2d side = smallest_rectangle(flat);
      axes.col((about + 1) % 3) = side.x() * u + side.y() * v;
      axes.col((about + 2) % 3) = side.x() * v - side.y() * u;
      volume = size_along(points, axes).prod();
    }
    if (!(volume < before * (1 - 1e-9))) break;
  }
  return axes;
}

std::vector<Eigen::Matrix3d> starting_axes(const std::vector<Vector3d>& points) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : points) centre += p / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - centre) * (p - centre).transpose();
  Eigen::Matrix3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  if (principal.determinant() < 0) principal.col(0) *= -1;
  std::vector<Eigen::Matrix3d> starts = {principal};
  for (const Eigen::Quaterniond& turn : icosahedral_rotations()) starts.push_back(turn.toRotationMatrix());
  return starts;
}

/// The longest side first; right-handed.
Eigen::Matrix3d ordered(const Eigen::Matrix3d& axes, const Vector3d& size) {
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size[a] > size[b]; });
  Eigen::Matrix3d turned;
  for (int i = 0; i < 3; ++i) turned.col(i) = axes.col(order[static_cast<std::size_t>(i)]);
  for (int i = 0; i < 2; ++i) {
    Eigen::Index largest = 0;
    turned.col(i).cwiseAbs().maxCoeff(&largest);
    if (turned(largest, i) < 0) turned.col(i) *= -1;
  }
  turned.col(2) = turned.col(0).cross(turned.col(1)).normalized();
  return turned;
}

OrientedBox box_along(const Mesh& mesh, const std::vector<std::uint32_t>& vertices, const Eigen::Matrix3d& axes) {
  Eigen::AlignedBox3d box;
  for (const std::uint32_t v : vertices) box.extend(axes.transpose() * mesh.positions_m[v].cast<double>());
  return {axes * box.center(), axes, box.sizes()};
}

}  // namespace

OrientedBox find_oriented_box(const Mesh& mesh) {
  SCANKNIT_CHECK(!mesh.empty());
  const std::vector<std::uint32_t> vertices = used_vertices(mesh);
  const std::vector<Vector3d> points = extreme_points(mesh, vertices);
  std::vector<Eigen::Matrix3d> axes = starting_axes(points);
  tbb::parallel_for(std::size_t{0}, axes.size(), [&](std::size_t i) { axes[i] = shrink_box(points, axes[i]); });
  const auto volume_along = [&](const Eigen::Matrix3d& a) { return size_along(points, a).prod(); };
  Eigen::Matrix3d best = Eigen::Matrix3d::Identity();  // kept where no turn makes the box smaller
  double least = volume_along(best) * (1 - 1e-9);
  for (const Eigen::Matrix3d& candidate : axes) {
    const double volume = volume_along(candidate);
    if (volume < least) std::tie(best, least) = std::pair(candidate, volume);
  }
  const OrientedBox found = box_along(mesh, vertices, ordered(best, size_along(points, best)));
  const OrientedBox upright = box_along(mesh, vertices, Eigen::Matrix3d::Identity());
  if (found.volume_m3() <= upright.volume_m3()) return found;
  return box_along(mesh, vertices, ordered(upright.axes, upright.size_m));
}

}  // namespace scanknit
