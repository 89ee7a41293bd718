#include "measure/fit/circle_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/counter_random.h"
#include "measure/fit/surface_patch.h"

namespace scanknit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAcrossAxis = 0.34;      // sine of 20 degrees: a wall's normals are square to the axis
constexpr double kTowardsAxis = 0.94;     // cosine of 20 degrees: and point to it or away
constexpr std::size_t kMostTried = 4000;  // pieces

/// A cylinder, with a frame across its axis.
struct Cylinder {
  Vector3d axis, right, up;
  Vector2d centre;
  double radius_m = 0;
  bool is_hole = false;

  void set_axis(const Vector3d& direction) {
    axis = direction;
    right = direction.unitOrthogonal();
    up = axis.cross(right);
  }
  [[nodiscard]] Vector2d flat(const Vector3d& p) const { return {right.dot(p), up.dot(p)}; }
  [[nodiscard]] double off(const PatchPiece& piece) const { return (flat(piece.middle_m) - centre).norm() - radius_m; }

  [[nodiscard]] bool has_on_wall(const PatchPiece& piece, double most_off_m) const {
    if (std::abs(piece.normal.dot(axis)) > kAcrossAxis || std::abs(off(piece)) > most_off_m) return false;
    const double outwards = flat(piece.normal).dot((flat(piece.middle_m) - centre).normalized());
    return (is_hole ? -outwards : outwards) >= kTowardsAxis;
  }
};

/// The cylinder through two pieces, square to their normals; nothing where these are parallel or do not agree.
std::optional<Cylinder> cylinder_through(const PatchPiece& a, const PatchPiece& b, double most_radius_m) {
  constexpr double kLeastTurn = 0.2, kAgree = 0.1;
  const Vector3d across = a.normal.cross(b.normal);
  if (across.norm() < kLeastTurn) return std::nullopt;
  Cylinder found;
  found.set_axis(across.normalized());
  const Vector2d pa = found.flat(a.middle_m), pb = found.flat(b.middle_m);
  const Vector2d na = found.flat(a.normal), nb = found.flat(b.normal);
  const double turn = na.x() * nb.y() - na.y() * nb.x();
  if (std::abs(turn) < kLeastTurn / 2) return std::nullopt;
  const Vector2d between = pb - pa;
  const double along = (between.x() * nb.y() - between.y() * nb.x()) / turn;  // pa + along na is on both normals
  found.centre = pa + along * na;
  const double ra = (pa - found.centre).norm(), rb = (pb - found.centre).norm();
  found.radius_m = (ra + rb) / 2;
  found.is_hole = along > 0;
  const bool agrees = std::abs(ra - rb) <= kAgree * found.radius_m;
  if (!agrees || !(found.radius_m > 0 && found.radius_m <= most_radius_m)) return std::nullopt;
  return found;
}

std::vector<PatchPiece> wall_of(const Cylinder& cylinder, const std::vector<PatchPiece>& pieces, double most_off_m) {
  std::vector<PatchPiece> wall;
  for (const PatchPiece& piece : pieces) {
    if (cylinder.has_on_wall(piece, most_off_m)) wall.push_back(piece);
  }
  return wall;
}

double wall_area(const std::vector<PatchPiece>& wall) {
  double area = 0;
  for (const PatchPiece& piece : wall) area += piece.area_m2;
  return area;
}

/// How much of the way round has a piece, in 72 parts.
double arc_of(const Cylinder& cylinder, const std::vector<PatchPiece>& wall) {
  constexpr std::size_t kParts = 72;
  std::array<bool, kParts> is_seen = {};
  for (const PatchPiece& piece : wall) {
    const Vector2d away = cylinder.flat(piece.middle_m) - cylinder.centre;
    const double turn = std::atan2(away.y(), away.x()) / (2 * std::numbers::pi) + 0.5;
    is_seen[std::min(static_cast<std::size_t>(turn * kParts), kParts - 1)] = true;
  }
  return 2 * std::numbers::pi * static_cast<double>(std::count(is_seen.begin(), is_seen.end(), true)) / kParts;
}

/// The axis to which the wall's normals are square, and the circle of least squares about it (Gauss-Newton).
void refine(Cylinder& cylinder, const std::vector<PatchPiece>& wall) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  for (const PatchPiece& piece : wall) normals += piece.area_m2 * piece.normal * piece.normal.transpose();
  Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normals).eigenvectors().col(0);
  if (axis.dot(cylinder.axis) < 0) axis *= -1;
  Vector3d middle = Vector3d::Zero();
  const double area = wall_area(wall);
  for (const PatchPiece& piece : wall) middle += piece.middle_m * piece.area_m2 / area;
  const Vector3d on_axis = cylinder.centre.x() * cylinder.right + cylinder.centre.y() * cylinder.up +
                           cylinder.axis.dot(middle) * cylinder.axis;
  cylinder.set_axis(axis);
  cylinder.centre = cylinder.flat(on_axis);
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const PatchPiece& piece : wall) {
      const Vector2d away = cylinder.flat(piece.middle_m) - cylinder.centre;
      const Vector3d J(-away.x() / away.norm(), -away.y() / away.norm(), -1);
      A += piece.area_m2 * J * J.transpose();
      b -= piece.area_m2 * (away.norm() - cylinder.radius_m) * J;
    }
    const Vector3d step = A.ldlt().solve(b);
    if (!step.allFinite()) return;
    cylinder.centre += step.head<2>();
    cylinder.radius_m += step.z();
  }
}

std::vector<PatchPiece> thinned(const std::vector<PatchPiece>& pieces) {
  const std::size_t every = pieces.size() / kMostTried + 1;
  std::vector<PatchPiece> few;
  for (std::size_t i = 0; i < pieces.size(); i += every) few.push_back(pieces[i]);
  return few;
}

std::optional<Cylinder> best_cylinder(const std::vector<PatchPiece>& pieces, double radius_m) {
  constexpr std::uint64_t kTrials = 600;
  constexpr double kMostOff = 0.04;  // of the radius
  const std::vector<PatchPiece> few = thinned(pieces);
  std::optional<Cylinder> best;
  double best_area = 0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    CounterRandom random(0, 1, trial);
    const auto pick = [&] { return static_cast<std::size_t>(random.uniform() * static_cast<double>(few.size())); };
    const std::size_t a = pick(), b = pick();
    const auto found = cylinder_through(few[a], few[b], 4 * radius_m);
    if (!found) continue;
    const double area = wall_area(wall_of(*found, few, kMostOff * found->radius_m));
    if (area > best_area) {
      best = found;
      best_area = area;
    }
  }
  return best;
}

}  // namespace

Result<FittedCircle> fit_circle(const Mesh& mesh, const Vector3d& at_m, double radius_m) {
  constexpr double kLeastArc = std::numbers::pi / 3;
  constexpr std::size_t kLeastPieces = 12;
  const auto too_little = [&] {
    return Error{ErrorCode::kTooLittle,
                 fmt::format("there is no round wall within {:.4g} mm of the point that goes round by 60 degrees; take "
                             "another radius, or a point in the hole",
                             radius_m * 1000)};
  };
  const std::vector<PatchPiece> pieces = patch_round(mesh, at_m, radius_m);
  if (pieces.size() < kLeastPieces) return too_little();
  std::optional<Cylinder> cylinder = best_cylinder(pieces, radius_m);
  if (!cylinder) return too_little();
  std::vector<PatchPiece> wall;
  for (const double most_off : {0.08, 0.05, 0.04}) {  // of the radius
    wall = wall_of(*cylinder, pieces, most_off * cylinder->radius_m);
    if (wall.size() < kLeastPieces) return too_little();
    refine(*cylinder, wall);
  }
  FittedCircle circle;
  circle.arc_rad = arc_of(*cylinder, wall);
  if (circle.arc_rad < kLeastArc || !(cylinder->radius_m > 0)) return too_little();
  circle.axis = cylinder->axis;
  circle.radius_m = cylinder->radius_m;
  circle.is_hole = cylinder->is_hole;
  circle.wall_area_m2 = wall_area(wall);
  circle.share = circle.wall_area_m2 / wall_area(pieces);
  double along = 0, squares = 0;
  for (const PatchPiece& piece : wall) {
    along += piece.area_m2 * piece.middle_m.dot(cylinder->axis) / circle.wall_area_m2;
    squares += piece.area_m2 * cylinder->off(piece) * cylinder->off(piece) / circle.wall_area_m2;
  }
  circle.centre_m =
      cylinder->centre.x() * cylinder->right + cylinder->centre.y() * cylinder->up + along * cylinder->axis;
  circle.rms_m = std::sqrt(squares);
  return circle;
}

}  // namespace scanknit
