#include "fusion/silhouette/silhouette_axis.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/rotation.h"

namespace scanknit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMostOff_px = 3;

Error axis_error(std::string message) {
  return {ErrorCode::kInput, std::move(message), "silhouettes of a turntable"};
}

/// The corners of the smallest convex polygon round the points (A. M. Andrew 1979).
std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vector2d> hull;
  const auto turns_left = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()) > 0;
  };
  const auto add = [&](const Vector2d& p, std::size_t least) {
    while (hull.size() >= least + 2 && !turns_left(hull[hull.size() - 2], hull.back(), p)) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vector2d& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

/// Where the outline crosses the lines between pixels.
std::vector<Vector2d> outline_points(const Silhouette& silhouette) {
  std::vector<Vector2d> points;
  const OutlineRect rect = *silhouette.bounds();
  const auto at = [&](int x, int y) { return silhouette.distance_px(x, y); };
  const int left = std::max(1, static_cast<int>(rect.left)), right = static_cast<int>(rect.right);
  const int top = std::max(1, static_cast<int>(rect.top)), bottom = static_cast<int>(rect.bottom);
  for (int y = top - 1; y <= bottom; ++y) {
    for (int x = left - 1; x <= right; ++x) {
      const double own = at(x, y), next = at(x + 1, y), below = at(x, y + 1);
      if ((own < 0) != (next < 0)) points.emplace_back(x + own / (own - next), y);
      if ((own < 0) != (below < 0)) points.emplace_back(x, y + own / (own - below));
    }
  }
  return points;
}

/// Two pictures whose tangent planes are compared.
struct ViewPair {
  std::size_t a, b;
};

/// Rays to the convex outline of each picture, in the camera's frame.
class OutlineRays {
 public:
  OutlineRays(std::span<const TurnedSilhouette> pictures, const CameraIntrinsics& camera)
      : pictures_(pictures), focal_(focal_length(camera)) {
    for (const TurnedSilhouette& picture : pictures) {
      std::vector<Vector3d> rays;
      for (const Vector2d& p : convex_hull(outline_points(*picture.silhouette))) {
        rays.push_back(camera.unproject(p.x(), p.y(), 1).normalized());
      }
      rays_.push_back(std::move(rays));
    }
    choose_pairs();
  }

  [[nodiscard]] bool has_pairs() const { return !pairs_.empty(); }

  /// For each pair and each of its two tangent planes: how many pixels the outlines miss one another.
  [[nodiscard]] Eigen::VectorXd residuals(const SilhouetteAxis& axis) const {
    const std::vector<Pose> poses = poses_round(axis, pictures_);
    Eigen::VectorXd all(2 * static_cast<Eigen::Index>(pairs_.size()));
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const auto [low, high] = misses(poses[pairs_[i].a], poses[pairs_[i].b], pairs_[i], axis.point);
      all[2 * static_cast<Eigen::Index>(i)] = low;
      all[2 * static_cast<Eigen::Index>(i) + 1] = high;
    }
    return all;
  }

 private:
  /// Pairs that turned by a fifth to two fifths of a turn tell most: there the two views differ, and tangents are long.
  void choose_pairs() {
    constexpr std::size_t kMostPairs = 240;
    std::vector<ViewPair> all;
    for (std::size_t a = 0; a < pictures_.size(); ++a) {
      for (std::size_t b = a + 1; b < pictures_.size(); ++b) {
        const double turn = std::abs(std::remainder(pictures_[b].angle_rad - pictures_[a].angle_rad, kFullTurn));
        if (turn > 20 * kDegree && turn < 160 * kDegree) all.push_back({a, b});
      }
    }
    const std::size_t every = std::max<std::size_t>(1, all.size() / kMostPairs);
    for (std::size_t i = 0; i < all.size(); i += every) pairs_.push_back(all[i]);
  }

  struct Tangent {
    double angle_rad;
    double lever;  ///< sine of the angle between its ray and the baseline
  };
  struct Tangents {
    Tangent low{std::numeric_limits<double>::max(), 0}, high{std::numeric_limits<double>::lowest(), 0};
  };

  [[nodiscard]] std::pair<double, double> misses(const Pose& a, const Pose& b, const ViewPair& pair,
                                                 const Vector3d& middle) const {
    const Vector3d baseline = b.translation() - a.translation();
    const double length = baseline.norm();
    if (!(length > 1e-9)) return {0, 0};
    const Vector3d along = baseline / length;
    Vector3d u = middle - a.translation();
    u -= u.dot(along) * along;
    if (!(u.norm() > 1e-9)) return {0, 0};
    u.normalize();
    const Vector3d v = along.cross(u);
    const auto tangents = [&](const Pose& pose, std::size_t picture) {
      Tangents both;
      for (const Vector3d& ray : rays_[picture]) {
        const Vector3d world = pose.linear() * ray;
        const double x = world.dot(u), y = world.dot(v);
        const Tangent tangent{std::atan2(y, x), std::hypot(x, y)};
        if (tangent.angle_rad < both.low.angle_rad) both.low = tangent;
        if (tangent.angle_rad > both.high.angle_rad) both.high = tangent;
      }
      return both;
    };
    const Tangents of_a = tangents(a, pair.a), of_b = tangents(b, pair.b);
    const auto miss = [&](const Tangent& s, const Tangent& t) {
      return (s.angle_rad - t.angle_rad) * focal_ * (s.lever + t.lever) / 2;
    };
    return {miss(of_a.low, of_b.low), miss(of_a.high, of_b.high)};
  }

  std::span<const TurnedSilhouette> pictures_;
  double focal_;
  std::vector<std::vector<Vector3d>> rays_;
  std::vector<ViewPair> pairs_;
};

/// The axis by three numbers: its tilt towards the camera and its roll in the picture, radians, and where it passes the
/// camera at the side, as a share of the distance.
SilhouetteAxis axis_of(const Vector3d& parameters, double distance_m, double sense) {
  SilhouetteAxis axis;
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(parameters.y(), Vector3d::UnitZ()) * Eigen::AngleAxisd(parameters.x(), Vector3d::UnitX()))
          .toRotationMatrix();
  axis.direction = sense * (turn * Vector3d::UnitY());
  axis.point = Vector3d(parameters.z(), 0, 1) * distance_m;
  return axis;
}

/// Without the largest tenth: a mask may be wrong in a few pictures.
double robust_square(const Eigen::VectorXd& residuals) {
  std::vector<double> squares;
  for (Eigen::Index i = 0; i < residuals.size(); ++i) squares.push_back(residuals[i] * residuals[i]);
  const auto kept = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() * 9 / 10);
  std::nth_element(squares.begin(), kept, squares.end());
  double sum = 0;
  for (auto square = squares.begin(); square != kept; ++square) sum += *square;
  return sum / static_cast<double>(std::max<std::ptrdiff_t>(1, kept - squares.begin()));
}

struct Fit {
  Vector3d parameters = Vector3d::Zero();
  double mean_square = 0;
};

/// Levenberg-Marquardt with Huber's weights, `most_rounds` at most.
Fit refine(const OutlineRays& rays, Vector3d parameters, double distance_m, double sense, int most_rounds) {
  const auto residuals = [&](const Vector3d& at) { return rays.residuals(axis_of(at, distance_m, sense)); };
  Eigen::VectorXd now = residuals(parameters);
  double cost = robust_square(now);
  double damping = 1e-3;
  for (int round = 0; round < most_rounds && damping < 1e6; ++round) {
    constexpr double kStep = 1e-5;
    Eigen::MatrixX3d jacobian(now.size(), 3);
    for (int k = 0; k < 3; ++k) {
      jacobian.col(k) =
          (residuals(parameters + kStep * Vector3d::Unit(k)) - residuals(parameters - kStep * Vector3d::Unit(k))) /
          (2 * kStep);
    }
    const double scale = std::max(0.5, 1.5 * std::sqrt(cost));
    const Eigen::VectorXd weights =
        now.unaryExpr([&](double r) { return std::abs(r) <= scale ? 1.0 : scale / std::abs(r); });
    const Eigen::Matrix3d normal = jacobian.transpose() * weights.asDiagonal() * jacobian;
    const Vector3d gradient = jacobian.transpose() * weights.asDiagonal() * now;
    const Eigen::Matrix3d damped = normal + damping * Eigen::Matrix3d(normal.diagonal().asDiagonal());
    const Vector3d step = -damped.ldlt().solve(gradient);
    const Vector3d next = parameters + step;
    const Eigen::VectorXd there = residuals(next);
    const double next_cost = robust_square(there);
    if (!(next_cost < cost)) {
      damping *= 10;
      continue;
    }
    const bool is_done = step.norm() < 1e-9;
    parameters = next;
    now = there;
    cost = next_cost;
    damping = std::max(1e-9, damping / 5);
    if (is_done) break;
  }
  return {parameters, cost};
}

/// From several tilts; the one that is best after a few rounds goes on.
Fit best_fit(const OutlineRays& rays, double aside, double distance_m, double sense) {
  constexpr std::array kTilts_degrees = {-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0};
  constexpr int kFewRounds = 8, kMostRounds = 40;
  std::array<Fit, kTilts_degrees.size()> fits;
  tbb::parallel_for(std::size_t{0}, fits.size(), [&](std::size_t i) {
    fits[i] = refine(rays, {kTilts_degrees[i] * kDegree, 0, aside}, distance_m, sense, kFewRounds);
  });
  const Fit& best = *std::min_element(fits.begin(), fits.end(),
                                      [](const Fit& a, const Fit& b) { return a.mean_square < b.mean_square; });
  return refine(rays, best.parameters, distance_m, sense, kMostRounds);
}

Result<void> check_pictures(std::span<const TurnedSilhouette> pictures) {
  if (pictures.size() < 4) return axis_error("an axis needs at least four pictures");
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Silhouette& silhouette = *pictures[i].silhouette;
    const auto bounds = silhouette.bounds();
    const std::string which = "picture " + std::to_string(i);
    if (!bounds) return axis_error(which + ": the mask is empty");
    if (bounds->left < 1 || bounds->top < 1 || bounds->right > silhouette.width() - 2 ||
        bounds->bottom > silhouette.height() - 2) {
      return axis_error(which +
                        ": the picture's border cuts the thing; to find a turntable's axis all of it must be seen");
    }
  }
  return {};
}

}  // namespace

Result<SilhouetteAxis> find_silhouette_axis(std::span<const TurnedSilhouette> pictures, const CameraIntrinsics& camera,
                                            double distance_m) {
  if (auto sound = check_pictures(pictures); !sound) return sound.error();
  const OutlineRays rays(pictures, camera);
  if (!rays.has_pairs()) {
    return axis_error("no two pictures are between 20 and 160 degrees apart: check the angles, take more of the turn");
  }
  double aside = 0;
  for (const TurnedSilhouette& picture : pictures) aside += (picture.silhouette->middle_u() - camera.cx) / camera.fx;
  aside /= static_cast<double>(pictures.size());
  const Fit one_way = best_fit(rays, aside, distance_m, 1), other_way = best_fit(rays, aside, distance_m, -1);
  const bool is_one_way = one_way.mean_square <= other_way.mean_square;
  const Fit& best = is_one_way ? one_way : other_way;
  SilhouetteAxis axis = axis_of(best.parameters, distance_m, is_one_way ? 1 : -1);
  axis.off_px = std::sqrt(best.mean_square);
  axis.other_off_px = std::sqrt((is_one_way ? other_way : one_way).mean_square);
  if (!(axis.off_px <= kMostOff_px)) {
    return axis_error("no axis explains the silhouettes: they miss one another by " +
                      std::to_string(static_cast<int>(std::lround(std::min(axis.off_px, 1e6)))) +
                      " pixels. Check that the camera stood still, the angles, and the masks");
  }
  return axis;
}

std::vector<Pose> poses_round(const SilhouetteAxis& axis, std::span<const TurnedSilhouette> pictures) {
  std::vector<Pose> poses;
  for (const TurnedSilhouette& picture : pictures) {
    // The thing turned by +angle: as it sees it, the camera turned back.
    const Eigen::AngleAxisd back(-picture.angle_rad, axis.direction);
    poses.push_back(Eigen::Translation3d(axis.point) * back * Eigen::Translation3d(-axis.point));
  }
  return poses;
}

}  // namespace scanknit
