#include "fusion/turntable/turntable_space.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

using Eigen::Vector3d;

constexpr double kWidest = 0.99;   // of a picture's distances from the axis: beyond are stray pixels
constexpr double kLowest = 0.01;   // and of its heights
constexpr double kUsually = 0.85;  // of the pictures are no wider: a hand comes in fewer than the rest
constexpr double kMargin = 1.15;
constexpr double kMargin_m = 0.01;
constexpr std::size_t kFewestPoints = 100;

/// Quantile of a list that is not empty.
double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Calls `visit(p_camera, x, y)` for each pixel with depth.
template <typename Visit>
void for_each_point(const DepthImage& depth_m, const CameraIntrinsics& camera, const Visit& visit) {
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const double z = static_cast<double>(depth_m.at(x, y));
      if (z > 0) visit(camera.unproject(x, y, z), x, y);
    }
  }
}

/// Unit normal of the surface through pixels a few steps aside; nothing beside an edge or a hole.
std::optional<Vector3d> normal_at(const DepthImage& depth_m, const CameraIntrinsics& camera, int x, int y) {
  constexpr int kStep = 3;
  constexpr double kEdge = 0.05;  // of the depth
  const auto point = [&](int u, int v) -> std::optional<Vector3d> {
    if (!depth_m.contains(u, v)) return std::nullopt;
    const double z = static_cast<double>(depth_m.at(u, v));
    if (!(z > 0) || std::abs(z - static_cast<double>(depth_m.at(x, y))) > kEdge * z) return std::nullopt;
    return camera.unproject(u, v, z);
  };
  const auto left = point(x - kStep, y);
  const auto right = point(x + kStep, y);
  const auto above = point(x, y - kStep);
  const auto below = point(x, y + kStep);
  if (!left || !right || !above || !below) return std::nullopt;
  return (*below - *above).cross(*right - *left).normalized();
}

/// Heights of still surfaces across the axis, within `radius_m` of it.
std::vector<double> flat_heights(const DepthImage& still_m, const CameraIntrinsics& camera, const TurntableSpace& space,
                                 double radius_m) {
  constexpr double kAcross = 0.95;  // cosine: 18 degrees
  std::vector<double> heights;
  for_each_point(still_m, camera, [&](const Vector3d& p, int x, int y) {
    if (space.distance_of(p) > radius_m) return;
    const auto normal = normal_at(still_m, camera, x, y);
    if (normal && std::abs(normal->dot(space.up)) > kAcross) heights.push_back(space.height_of(p));
  });
  return heights;
}

/// The highest level, up to `most_m`, at which at least a third as many points lie as at the fullest.
std::optional<double> highest_level(std::vector<double> heights, double most_m) {
  constexpr double kLevel_m = 0.004;
  constexpr double kPart = 0.33;
  std::erase_if(heights, [&](double h) { return h > most_m; });
  if (heights.size() < kFewestPoints) return std::nullopt;
  std::sort(heights.begin(), heights.end());
  const auto level_above = [&](double h) {
    const auto begin = std::lower_bound(heights.begin(), heights.end(), h);
    return std::pair(begin, std::upper_bound(begin, heights.end(), h + kLevel_m));
  };
  std::ptrdiff_t fullest = 0;
  for (const double h : heights) {
    const auto [begin, end] = level_above(h);
    fullest = std::max(fullest, end - begin);
  }
  const auto enough = std::max(static_cast<std::ptrdiff_t>(kFewestPoints),
                               static_cast<std::ptrdiff_t>(kPart * static_cast<double>(fullest)));
  for (std::size_t i = heights.size(); i-- > 0;) {
    const auto [begin, end] = level_above(heights[i]);
    if (end - begin < enough) continue;
    // The fullest of the levels that begin close below, and its median.
    auto best = std::pair(begin, end);
    for (auto at = begin; at != heights.begin() && *at > heights[i] - kLevel_m; --at) {
      const auto level = level_above(*at);
      if (level.second - level.first > best.second - best.first) best = level;
    }
    return *(best.first + (best.second - best.first) / 2);
  }
  return std::nullopt;
}

}  // namespace

TurntableSpace moved(const TurntableSpace& space, const Pose& T_to_from) {
  TurntableSpace result = space;
  result.axis.direction = T_to_from.linear() * space.axis.direction;
  result.axis.point = T_to_from * space.axis.point;
  result.up = T_to_from.linear() * space.up;
  return result;
}

Pose T_table_camera(const TurntableSpace& space, double beside_m) {
  const Eigen::Vector3d y = -space.up;
  const Eigen::Vector3d x = (Eigen::Vector3d::UnitX() - y * y.x()).normalized();
  const double height = space.disc_m.value_or(space.foot_m);
  Pose T = Pose::Identity();
  T.linear() << x, y, x.cross(y);
  T.linear().transposeInPlace();
  T.translation() = -(T.linear() * (space.axis.point + height * space.up)) + Eigen::Vector3d(0, beside_m, 0);
  return T;
}

std::optional<TurntableSpace> find_space(const std::vector<DepthImage>& samples, const StillScene& still,
                                         const CameraIntrinsics& camera, const TurntableAxis& axis) {
  TurntableSpace space;
  space.axis = axis;
  // The camera looks down on the disc, or across it with its own top upwards.
  constexpr double kLooksAcross = 0.05;
  const double towards_camera = axis.direction.dot(-axis.point.normalized());
  const double tells = std::abs(towards_camera) > kLooksAcross ? towards_camera : -axis.direction.y();
  space.up = tells > 0 ? axis.direction : Vector3d(-axis.direction);

  std::vector<double> widths, feet;
  for (const DepthImage& sample : samples) {
    std::vector<double> distances, heights;
    for_each_point(sample, camera, [&](const Vector3d& p, int, int) {
      distances.push_back(space.distance_of(p));
      heights.push_back(space.height_of(p));
    });
    if (distances.size() < kFewestPoints) continue;
    widths.push_back(quantile(distances, kWidest));
    feet.push_back(quantile(heights, kLowest));
  }
  if (widths.empty()) return std::nullopt;
  const double width_m = quantile(widths, kUsually);
  space.radius_m = kMargin * width_m + kMargin_m;
  space.foot_m = quantile(feet, 0.3);
  if (still.empty()) return space;
  constexpr double kAround = 1.4;  // of the object's radius: more of the disc is seen
  const double near_foot_m = space.foot_m + kMargin_m;
  space.disc_m = highest_level(flat_heights(still.depth_m(), camera, space, kAround * width_m), near_foot_m);
  return space;
}

void cut_to_space(DepthImage& depth_m, const CameraIntrinsics& camera, const TurntableSpace& space, double below_m) {
  const double floor_m = space.disc_m.value_or(space.foot_m) - below_m;
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      float& z = depth_m.at(x, y);
      if (!(z > 0)) continue;
      const Vector3d p = camera.unproject(x, y, static_cast<double>(z));
      if (space.height_of(p) < floor_m || space.distance_of(p) > space.radius_m) z = 0;
    }
  });
}

}  // namespace scanknit
