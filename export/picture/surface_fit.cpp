#include "export/picture/surface_fit.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/median.h"
#include "export/picture/colour_ramp.h"
#include "export/picture/preview.h"

namespace scanknit {
namespace {

constexpr float kGrazing = 0.2f;  // cosine; flatter than that a pixel covers too much of the surface

/// How far from the surface `frame` has a vertex; nothing when it did not see it.
std::optional<double> distance_in(const Eigen::Vector3f& position_m, const Eigen::Vector3f& normal,
                                  const PosedDepth& frame, const Pose& T_camera_world, const FitBand& band) {
  const Eigen::Vector3d p = T_camera_world * position_m.cast<double>();
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector3d n = T_camera_world.linear() * normal.cast<double>();
  if (!(p.dot(n) < -kGrazing * p.norm())) return std::nullopt;  // seen from behind, edge-on, or without direction
  const Eigen::Vector2d pixel = frame.intrinsics.project(p);
  const double width = frame.depth_m->width(), height = frame.depth_m->height();
  if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5)) {
    return std::nullopt;
  }
  const int u = static_cast<int>(std::floor(pixel.x() + 0.5)), v = static_cast<int>(std::floor(pixel.y() + 0.5));
  const double depth_m = frame.depth_m->at(u, v);
  if (!(depth_m > 0)) return std::nullopt;
  const double distance_m = (frame.intrinsics.unproject(u, v, depth_m) - p).dot(n);
  const double farthest_m = std::max(band.least_m, band.sigmas * band.noise.sigma_m(depth_m));
  if (!(std::abs(distance_m) <= farthest_m)) return std::nullopt;
  return distance_m;
}

template <std::size_t N, typename Share>
ColourImage draw_map(const Mesh& mesh, const SurfaceFit& fit, const Rgb8 (&ramp)[N], UpAxis world_up,
                     const std::optional<Pose>& T_world_scanner, Share&& share) {
  SCANKNIT_CHECK(fit.seen_by.size() == mesh.positions_m.size());
  std::vector<Rgb8> painted(mesh.positions_m.size());
  for (std::size_t i = 0; i < painted.size(); ++i) {
    painted[i] = fit.seen_by[i] == 0 ? kUnseenColour : colour_on(ramp, share(i));
  }
  return render_two_views(mesh, world_up, T_world_scanner, painted);
}

}  // namespace

SurfaceFit fit_surface(const Mesh& mesh, std::span<const PosedDepth> frames, const FitBand& band) {
  const std::size_t n = mesh.positions_m.size();
  SCANKNIT_CHECK(mesh.normals.size() == n && frames.size() <= 65'535);
  std::vector<Pose> T_camera_world;
  for (const PosedDepth& frame : frames) T_camera_world.push_back(frame.T_world_camera.inverse());
  SurfaceFit fit;
  fit.frames = frames.size();
  fit.seen_by.resize(n);
  fit.error_m.resize(n);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, 4096), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      double sum_m = 0;
      for (std::size_t k = 0; k < frames.size(); ++k) {
        const auto distance_m = distance_in(mesh.positions_m[i], mesh.normals[i], frames[k], T_camera_world[k], band);
        if (!distance_m) continue;
        sum_m += std::abs(*distance_m);
        ++fit.seen_by[i];
      }
      if (fit.seen_by[i] > 0) fit.error_m[i] = static_cast<float>(sum_m / fit.seen_by[i]);
    }
  });
  std::vector<float> errors_m;
  errors_m.reserve(n - static_cast<std::size_t>(std::count(fit.seen_by.begin(), fit.seen_by.end(), 0)));
  for (std::size_t i = 0; i < n; ++i) {
    if (fit.seen_by[i] > 0) errors_m.push_back(fit.error_m[i]);
  }
  fit.seen_share = n == 0 ? 0 : static_cast<double>(errors_m.size()) / static_cast<double>(n);
  fit.median_m = static_cast<double>(percentile(errors_m, 0.5));
  fit.p95_m = static_cast<double>(percentile(errors_m, 0.95));
  return fit;
}

double rounded_scale_end_m(double most_m) {
  constexpr double kLeastM = 1e-6;
  const double end_m = std::max(most_m, kLeastM);
  const double decade = std::pow(10.0, std::floor(std::log10(end_m)));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (end_m <= step * decade) return step * decade;
  }
  return 10 * decade;
}

double error_map_end_m(const SurfaceFit& fit) {
  return rounded_scale_end_m(fit.p95_m);
}

std::size_t coverage_map_end(const SurfaceFit& fit) {
  const auto most = std::max_element(fit.seen_by.begin(), fit.seen_by.end());
  return most == fit.seen_by.end() ? 1 : std::max<std::size_t>(1, *most);
}

ColourImage draw_error_map(const Mesh& mesh, const SurfaceFit& fit, UpAxis world_up,
                           const std::optional<Pose>& T_world_scanner) {
  const double end_m = error_map_end_m(fit);
  return draw_map(mesh, fit, kErrorRamp, world_up, T_world_scanner,
                  [&](std::size_t i) { return fit.error_m[i] / end_m; });
}

ColourImage draw_coverage_map(const Mesh& mesh, const SurfaceFit& fit, UpAxis world_up,
                              const std::optional<Pose>& T_world_scanner) {
  const auto end = static_cast<double>(coverage_map_end(fit));
  return draw_map(mesh, fit, kCoverageRamp, world_up, T_world_scanner,
                  [&](std::size_t i) { return fit.seen_by[i] / end; });
}

}  // namespace scanknit
