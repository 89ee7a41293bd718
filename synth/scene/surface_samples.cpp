#include "synth/scene/surface_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/counter_random.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;

/// Cubes that contain the whole shell of half-thickness `half_shell_m` about the surface.
struct Shell {
  std::vector<Vector3d> centres;
  double cell_m = 0;
  double half_shell_m = 0;
};

void collect_cells(const SyntheticScene& scene, const Vector3d& centre, double side_m, int levels, Shell& shell) {
  const double half_diagonal = side_m * std::sqrt(3.0) / 2;
  if (std::abs(scene.distance(centre)) > half_diagonal + shell.half_shell_m) return;
  if (levels == 0) {
    shell.centres.push_back(centre);
    return;
  }
  for (int octant = 0; octant < 8; ++octant) {
    const Vector3d direction((octant & 1) != 0 ? 1 : -1, (octant & 2) != 0 ? 1 : -1, (octant & 4) != 0 ? 1 : -1);
    collect_cells(scene, centre + side_m / 4 * direction, side_m / 2, levels - 1, shell);
  }
}

Shell shell_of(const SyntheticScene& scene) {
  constexpr int kLevels = 7;  // 128 cells along the longest side
  const Eigen::AlignedBox3d box = scene.bounds();
  const double side = box.sizes().maxCoeff() * 1.05;  // room for the shell outside the bounds
  Shell shell;
  shell.cell_m = side / (1 << kLevels);
  shell.half_shell_m = shell.cell_m / 8;  // thin compared to the radius of curvature, thick enough to be hit
  collect_cells(scene, box.center(), side, kLevels, shell);
  return shell;
}

/// Draws a random point in the shell's cells; if it is within the shell, returns the surface point nearest to it.
std::optional<TruthPoint> try_sample(const SyntheticScene& scene, const Shell& shell, CounterRandom random) {
  const auto cells = static_cast<double>(shell.centres.size());
  const auto cell = std::min(static_cast<std::size_t>(random.uniform() * cells), shell.centres.size() - 1);
  Vector3d p = shell.centres[cell];
  for (int axis = 0; axis < 3; ++axis) p[axis] += shell.cell_m * (random.uniform() - 0.5);
  const double bound = scene.distance(p);
  if (std::abs(bound) > shell.half_shell_m) return std::nullopt;
  const SurfacePoint foot = scene.nearest(p);
  if ((foot.position - p).norm() > shell.half_shell_m) return std::nullopt;
  return TruthPoint{foot.position.cast<float>(), foot.normal.cast<float>()};
}

}  // namespace

std::vector<TruthPoint> sample_surface(const SyntheticScene& scene, std::size_t count, std::uint64_t seed) {
  constexpr std::size_t kBatch = 1 << 16;
  constexpr std::size_t kMaxBatches = 1 << 16;    // ends the search for a scene without surface
  constexpr std::uint64_t kStream = 0x7275'7468;  // different from the streams of the noise, which are frame numbers
  std::vector<TruthPoint> points;
  if (count == 0) return points;
  points.reserve(count);
  const Shell shell = shell_of(scene);
  if (shell.centres.empty()) return points;
  std::vector<std::optional<TruthPoint>> batch(kBatch);
  for (std::size_t b = 0; b < kMaxBatches && points.size() < count; ++b) {
    tbb::parallel_for(std::size_t{0}, kBatch, [&](std::size_t i) {
      batch[i] = try_sample(scene, shell, CounterRandom(seed, kStream, b * kBatch + i));
    });
    for (std::size_t i = 0; i < kBatch && points.size() < count; ++i) {
      if (batch[i]) points.push_back(*batch[i]);
    }
  }
  return points;
}

void count_views(const RenderedView& view, const ViewCamera& camera, std::vector<TruthPoint>& points) {
  constexpr double kMinCosine = 0.1736;  // 80 degrees
  constexpr double kSlack_m = 0.0005;
  const CameraIntrinsics& intrinsics = camera.intrinsics();
  const double pixel_rad = 1 / std::min(intrinsics.fx, intrinsics.fy);
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const auto seen = camera.see(points[i].position_m.cast<double>());
    if (!seen) return;
    const Vector3d& p = seen->p_camera;
    const Vector3d n = seen->R_camera_world * points[i].normal.cast<double>();
    const double cosine = -n.dot(p) / p.norm();
    if (cosine < kMinCosine) return;
    const Eigen::Vector2d& pixel = seen->pixel;
    // Compares before rounding: a point beside the camera may project to a number too large for an int.
    if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < intrinsics.width - 0.5 &&
          pixel.y() < intrinsics.height - 0.5)) {
      return;
    }
    const auto x = static_cast<int>(std::lround(pixel.x()));
    const auto y = static_cast<int>(std::lround(pixel.y()));
    if (!view.depth_m.contains(x, y)) return;
    // Within a pixel the surface may slope by this much.
    const double slope_m = p.z() * pixel_rad * std::sqrt(1 - std::min(1.0, cosine * cosine)) / cosine;
    const double depth = static_cast<double>(view.depth_m.at(x, y));
    if (depth > 0 && p.z() <= depth + slope_m + kSlack_m) ++points[i].views;
  });
}

}  // namespace scanknit
