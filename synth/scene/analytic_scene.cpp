#include "synth/scene/analytic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.h"

namespace scanknit {

AnalyticScene::AnalyticScene(std::string name, CameraPath path, int default_frames, std::vector<Solid> solids)
    : SyntheticScene(std::move(name), std::move(path), default_frames), solids_(std::move(solids)) {
  SCANKNIT_CHECK(!solids_.empty());
  for (const Solid& solid : solids_) bounds_.extend(solid.bounds());
}

std::optional<double> AnalyticScene::intersect(const Ray& ray, double max_t_m) const {
  std::optional<double> first;
  for (const Solid& solid : solids_) {
    if (solid.is_missed_by(ray, first.value_or(max_t_m))) continue;
    if (const auto t = solid.intersect(ray, first.value_or(max_t_m))) first = t;
  }
  return first;
}

AnalyticScene::NearestSolid AnalyticScene::nearest_solid(const Eigen::Vector3d& p_world) const {
  NearestSolid best{0, solids_.front().field(p_world)};
  for (std::size_t i = 1; i < solids_.size(); ++i) {
    if (solids_[i].distance_bound(p_world) >= best.field.distance_m) continue;
    const FieldSample field = solids_[i].field(p_world);
    if (field.distance_m < best.field.distance_m) best = {i, field};
  }
  return best;
}

double AnalyticScene::distance(const Eigen::Vector3d& p_world) const {
  return nearest_solid(p_world).field.distance_m;
}

SurfacePoint AnalyticScene::nearest(const Eigen::Vector3d& p_world) const {
  const NearestSolid solid = nearest_solid(p_world);
  if (solid.field.distance_m < 0) return nearest_from_inside(p_world, solid);
  return {p_world - solid.field.distance_m * solid.field.gradient, solid.field.gradient, solid.index};
}

bool AnalyticScene::is_on_surface(const Eigen::Vector3d& p_world) const {
  constexpr double kRounding_m = 1e-8;
  return distance(p_world) > -kRounding_m;
}

// The surface of a union consists of faces of its solids, cut off where they dive into another solid. The nearest point
// is the foot on a face, or lies on a seam between two faces. (It ignores corners of three solids: there it returns the
// nearest seam point, or the bound.)
SurfacePoint AnalyticScene::nearest_from_inside(const Eigen::Vector3d& p_world, const NearestSolid& deepest) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  // Where the deepest solid's own foot is surface, no solid beyond it can be nearer: most points are of this kind.
  const bool is_simple = is_on_surface(p_world - deepest.field.distance_m * deepest.field.gradient);
  const double reach = is_simple ? std::abs(deepest.field.distance_m) : kFar;
  std::vector<FieldSample> fields;
  fields.reserve(solids_.size());
  for (const Solid& solid : solids_) {
    const bool is_beyond = solid.distance_bound(p_world) > reach;
    fields.push_back(is_beyond ? FieldSample{kFar, Eigen::Vector3d::UnitZ()} : solid.field(p_world));
  }

  double best = kFar;
  SurfacePoint result{p_world - deepest.field.distance_m * deepest.field.gradient, deepest.field.gradient,
                      deepest.index};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (std::abs(fields[i].distance_m) >= best) continue;
    const Eigen::Vector3d foot = p_world - fields[i].distance_m * fields[i].gradient;
    if (!is_on_surface(foot)) continue;
    best = std::abs(fields[i].distance_m);
    result = {foot, fields[i].gradient, i};
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (std::abs(fields[i].distance_m) >= best) continue;
    for (std::size_t j = i + 1; j < fields.size(); ++j) {
      if (std::max(std::abs(fields[i].distance_m), std::abs(fields[j].distance_m)) >= best) continue;
      const auto seam = nearest_on_seam(p_world, solids_[i], solids_[j]);
      if (!seam || (*seam - p_world).norm() >= best || !is_on_surface(*seam)) continue;
      best = (*seam - p_world).norm();
      result = {*seam, solids_[i].field(*seam).gradient, i};
    }
  }
  return result;
}

// Least |x - p| subject to both fields being zero, by Newton on the linearised constraints: x = p + l1 n1 + l2 n2 with
// n1 . x and n2 . x given by the tangent planes at the last x.
std::optional<Eigen::Vector3d> AnalyticScene::nearest_on_seam(const Eigen::Vector3d& p_world, const Solid& a,
                                                              const Solid& b) const {
  constexpr int kMaxSteps = 40;
  constexpr double kParallel = 1e-6;
  constexpr double kConverged_m = 1e-10;
  Eigen::Vector3d x = p_world;
  for (int step = 0; step < kMaxSteps; ++step) {
    const FieldSample fa = a.field(x);
    const FieldSample fb = b.field(x);
    const double cosine = fa.gradient.dot(fb.gradient);
    const double determinant = 1 - cosine * cosine;
    if (determinant < kParallel) return std::nullopt;
    const double ra = fa.gradient.dot(x - p_world) - fa.distance_m;
    const double rb = fb.gradient.dot(x - p_world) - fb.distance_m;
    const Eigen::Vector3d next =
        p_world + (ra - cosine * rb) / determinant * fa.gradient + (rb - cosine * ra) / determinant * fb.gradient;
    const double moved = (next - x).norm();
    x = next;
    if (moved < kConverged_m) return x;
  }
  return std::nullopt;
}

Eigen::Vector3d AnalyticScene::colour(const SurfacePoint& point) const {
  SCANKNIT_CHECK(point.part < solids_.size());
  return solids_[point.part].colour(point.position);
}

SurfaceMaterial AnalyticScene::material(const SurfacePoint& point) const {
  SCANKNIT_CHECK(point.part < solids_.size());
  return solids_[point.part].material();
}

}  // namespace scanknit
