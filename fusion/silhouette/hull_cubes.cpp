#include "fusion/silhouette/hull_cubes.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

namespace scanknit {
namespace {

using Eigen::Vector3d;

}  // namespace

HullCubes::HullCubes(std::span<const SilhouetteView> views) : views_(views) {
  for (const SilhouetteView& view : views) T_camera_world_.push_back(view.T_world_camera.inverse());
}

std::optional<HullCubes::Outline> HullCubes::outline_of(std::size_t i, const Vector3d& middle, double half_m) const {
  const SilhouetteView& view = views_[i];
  const Vector3d p = T_camera_world_[i] * middle;
  const double radius = std::numbers::sqrt3 * half_m;  // of the ball round the cube
  if (!(p.z() > 1.01 * radius)) return std::nullopt;
  // The ball is within the box of its extent across the axis, seen from as near and as far as it reaches.
  const auto span = [&](double across, double focal, double centre) {
    const double low = across - radius, high = across + radius;
    const double a = focal * low / (low < 0 ? p.z() - radius : p.z() + radius);
    const double b = focal * high / (high > 0 ? p.z() - radius : p.z() + radius);
    return std::pair(std::min(a, b) + centre, std::max(a, b) + centre);
  };
  const auto [left, right] = span(p.x(), view.camera.fx, view.camera.cx);
  const auto [top, bottom] = span(p.y(), view.camera.fy, view.camera.cy);
  return Outline{{left, top, right, bottom}, p.z() - radius, p.z() + radius};
}

std::optional<HullCubes::Range> HullCubes::range_of(std::size_t i, const Vector3d& middle, double half_m) const {
  const auto outline = outline_of(i, middle, half_m);
  if (!outline) return std::nullopt;
  const SilhouetteView& view = views_[i];
  const auto range = view.silhouette.range_px(outline->rect);
  if (!range) return std::nullopt;
  const double reach = view.silhouette.reach_px();
  const double per_px_near = outline->nearest_m / focal_length(view.camera);
  const double per_px_far = outline->farthest_m / focal_length(view.camera);
  // A distance that is as long as what is measured may be longer.
  const auto metres = [&](double px, bool is_least) {
    if (std::abs(px) >= reach - 0.01) return std::copysign(std::numeric_limits<double>::infinity(), px);
    return px * ((px > 0) == is_least ? per_px_near : per_px_far);
  };
  return Range{metres(range->least_px, true), metres(range->greatest_px, false)};
}

bool HullCubes::is_seen(const Vector3d& p) const {
  int seen = 0;
  for (std::size_t i = 0; i < views_.size() && seen < kFewestSilhouettes; ++i) {
    const Vector3d in_camera = T_camera_world_[i] * p;
    if (!(in_camera.z() > 0)) continue;
    const Eigen::Vector2d pixel = views_[i].camera.project(in_camera);
    if (views_[i].silhouette.sees(pixel.x(), pixel.y())) ++seen;
  }
  return seen == kFewestSilhouettes;
}

bool HullCubes::may_hold_hull(const Vector3d& middle, double half_m) const {
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const auto outline = outline_of(i, middle, half_m);
    if (!outline) continue;
    const Silhouette& silhouette = views_[i].silhouette;
    OutlineRect seen = outline->rect;
    seen.left = std::max(0.0, seen.left);
    seen.top = std::max(0.0, seen.top);
    seen.right = std::min<double>(silhouette.width() - 1, seen.right);
    seen.bottom = std::min<double>(silhouette.height() - 1, seen.bottom);
    if (seen.left > seen.right || seen.top > seen.bottom) continue;
    if (silhouette.range_px(seen)->least_px >= 0) return false;
  }
  return true;
}

bool HullCubes::may_hold_surface(const Vector3d& middle, double half_m, double band_m) const {
  bool is_inside_of_all = true;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    const auto range = range_of(i, middle, half_m);
    if (range && range->least_m >= band_m) return false;
    is_inside_of_all = is_inside_of_all && range && range->greatest_m <= -band_m;
  }
  return !is_inside_of_all;
}

}  // namespace scanknit
