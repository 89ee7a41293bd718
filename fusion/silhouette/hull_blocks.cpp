#include "fusion/silhouette/hull_blocks.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include "fusion/volume/block_index.h"

namespace scanknit {
namespace {

using Eigen::Vector3d;
using openvdb::Coord;

std::vector<Coord> halves_of(const std::vector<Coord>& cubes, int edge, const Coord& last) {
  std::vector<Coord> halves;
  for (const Coord& cube : cubes) {
    for (int k = 0; k < 8; ++k) {
      const Coord half = cube + Coord((k >> 2 & 1) * edge, (k >> 1 & 1) * edge, (k & 1) * edge);
      if (half.x() <= last.x() && half.y() <= last.y() && half.z() <= last.z()) halves.push_back(half);
    }
  }
  return halves;
}

}  // namespace

HullBlocks::HullBlocks(std::span<const SilhouetteView> views, const TsdfVolume& volume)
    : views_(views),
      cubes_(views_),
      voxel_size_m_(volume.config().voxel_size_m),
      band_m_(volume.tsdf().background()),
      budget_mib_(volume.config().memory_budget_mib) {
  for (const SilhouetteView& view : views) T_camera_world_.push_back(view.T_world_camera.inverse());
}

Vector3d HullBlocks::position(const Coord& index) const {
  return Vector3d(index.x(), index.y(), index.z()) * voxel_size_m_;
}

Result<std::vector<Coord>> HullBlocks::in_band(const Eigen::AlignedBox3d& box) const {
  constexpr double kFarthest = 1e9;  // voxels; indices must fit their type, with room to spare
  if (!(box.min().cwiseAbs().maxCoeff() / voxel_size_m_ < kFarthest) ||
      !(box.max().cwiseAbs().maxCoeff() / voxel_size_m_ < kFarthest)) {
    return Error{ErrorCode::kInput, "the thing is too far from the world's origin for this voxel size"};
  }
  constexpr std::size_t kBytesPerBlock = kBlockVoxels * (sizeof(float) + sizeof(WeightCode) + sizeof(ColourCode));
  constexpr std::size_t kTimesTheBudget = 4;  // cubes and blocks that only may meet the band are among them
  auto found = in_band(box, kTimesTheBudget * ((budget_mib_ << 20) / kBytesPerBlock));
  if (!found) {
    return Error{ErrorCode::kBudget,
                 "the hull needs far more memory than fusion.memory_budget: set a larger fusion.voxel_size"};
  }
  return *std::move(found);
}

/// Nothing if there are more than `most`.
std::optional<std::vector<Coord>> HullBlocks::in_band(const Eigen::AlignedBox3d& box, std::size_t most) const {
  const auto lowest = [&](double m) { return static_cast<int>(std::floor(m / voxel_size_m_ / kBlockEdgeVoxels)); };
  const Coord first(lowest(box.min().x()), lowest(box.min().y()), lowest(box.min().z()));
  const Coord last(lowest(box.max().x()), lowest(box.max().y()), lowest(box.max().z()));
  constexpr int kCubes = 32;  // at first, along the longest side
  const int longest = std::max({last.x() - first.x(), last.y() - first.y(), last.z() - first.z()});
  int edge = 1;  // blocks
  while (longest / edge >= kCubes) edge *= 2;
  std::vector<Coord> cubes;
  for (int x = first.x(); x <= last.x(); x += edge) {
    for (int y = first.y(); y <= last.y(); y += edge) {
      for (int z = first.z(); z <= last.z(); z += edge) cubes.emplace_back(x, y, z);
    }
  }
  for (;; edge /= 2) {
    cubes = those_in_the_band(cubes, edge);
    if (cubes.size() > most) return std::nullopt;
    if (edge == 1) break;
    cubes = halves_of(cubes, edge / 2, last);
  }
  for (Coord& cube : cubes) cube = Coord(cube.x() << 3, cube.y() << 3, cube.z() << 3);
  return cubes;
}

std::vector<Coord> HullBlocks::those_in_the_band(const std::vector<Coord>& cubes, int edge) const {
  std::vector<char> keeps(cubes.size());
  const double half_m = edge * kBlockEdgeVoxels * voxel_size_m_ / 2;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cubes.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vector3d origin = position(Coord(cubes[i].x() << 3, cubes[i].y() << 3, cubes[i].z() << 3));
      keeps[i] = cubes_.may_hold_surface(origin + Vector3d::Constant(half_m), half_m, band_m_) ? 1 : 0;
    }
  });
  std::vector<Coord> kept;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    if (keeps[i] != 0) kept.push_back(cubes[i]);
  }
  return kept;
}

std::array<HullBlocks::Look, kBlockVoxels> HullBlocks::look_at(const Coord& origin) const {
  std::array<Look, kBlockVoxels> looks;
  looks.fill({-band_m_, 0});
  std::vector<ViewOfPart> views(views_.size());
  for (unsigned part = 0; part < kBlockVoxels / kPartVoxels; ++part) {
    look_at_part(origin, {(part >> 2 & 1) * kPartEdge, (part >> 1 & 1) * kPartEdge, (part & 1) * kPartEdge}, views,
                 looks);
  }
  return looks;
}

void HullBlocks::look_at_part(const Coord& origin, const std::array<unsigned, 3>& low, std::vector<ViewOfPart>& views,
                              std::array<Look, kBlockVoxels>& looks) const {
  constexpr double kMiddle = (kPartEdge - 1) / 2.0;
  const Vector3d first = position(origin);
  const Vector3d middle = first + (Vector3d(low[0], low[1], low[2]) + Vector3d::Constant(kMiddle)) * voxel_size_m_;
  const double radius_m = std::numbers::sqrt3 * kMiddle * voxel_size_m_;
  for (std::size_t i = 0; i < views_.size(); ++i) views[i] = {greatest_m(i, middle, radius_m), i};
  // Those that may say most come first: soon they leave nothing to be said by the others, which see the whole part.
  std::sort(views.begin(), views.end(), std::greater<>());
  constexpr double kRounding = 1e-5;
  std::array<unsigned, kPartVoxels> voxels;
  for (unsigned n = 0; n < kPartVoxels; ++n) {
    voxels[n] = (low[0] + n / (kPartEdge * kPartEdge)) << 6 | (low[1] + n / kPartEdge % kPartEdge) << 3 |
                (low[2] + n % kPartEdge);
  }
  float least_m = -band_m_;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const auto [greatest_m, i] = views[k];
    if (std::isfinite(greatest_m) && (greatest_m + kRounding * band_m_ <= least_m || least_m >= band_m_)) {
      for (const unsigned n : voxels) looks[n].seen_by += static_cast<int>(views.size() - k);
      break;
    }
    look_from(i, first, voxels, looks);
    least_m = band_m_;
    for (const unsigned n : voxels) least_m = std::min(least_m, looks[n].distance_m);
  }
}

/// Distances to an outline change by at most a pixel a pixel. Between four pixels' centres, of which the mean square
/// distance from a point between them is half a pixel squared at most, the same holds for their means.
double HullBlocks::greatest_m(std::size_t i, const Vector3d& middle, double radius_m) const {
  constexpr double kNotSeen = std::numeric_limits<double>::infinity();
  constexpr double kSquaredCell = 0.5, kRounding_px = 0.02;  // distances are kept in 1/128 of a pixel
  const auto& [camera, pose, silhouette] = views_[i];
  const Vector3d p = T_camera_world_[i] * middle;
  if (!(p.z() > 1.01 * radius_m)) return kNotSeen;
  const Eigen::Vector2d pixel = camera.project(p);
  const double slant = std::hypot(p.x(), p.y()) / p.z();
  const double radius_px = std::max(std::abs(camera.fx), std::abs(camera.fy)) * radius_m *
                               std::sqrt(1 + slant * slant) / (p.z() - radius_m) +
                           kRounding_px;
  if (!silhouette.sees(pixel.x() - radius_px, pixel.y() - radius_px) ||
      !silhouette.sees(pixel.x() + radius_px, pixel.y() + radius_px)) {
    return kNotSeen;
  }
  const double greatest_px = static_cast<double>(silhouette.distance_px(pixel.x(), pixel.y())) +
                             std::sqrt(kSquaredCell) + std::sqrt(radius_px * radius_px + kSquaredCell) + kRounding_px;
  return greatest_px * (greatest_px > 0 ? p.z() + radius_m : p.z() - radius_m) / focal_length(camera);
}

void HullBlocks::look_from(std::size_t i, const Vector3d& first, const std::array<unsigned, kPartVoxels>& voxels,
                           std::array<Look, kBlockVoxels>& looks) const {
  const auto& [camera, pose, silhouette] = views_[i];
  const double metres_per_pixel_and_metre = 1 / focal_length(camera);
  for (const unsigned n : voxels) {
    const Vector3d p = first + Vector3d(n >> 6, n >> 3 & 7, n & 7) * voxel_size_m_;
    const Vector3d in_camera = T_camera_world_[i] * p;
    if (!(in_camera.z() > 0)) continue;
    const Eigen::Vector2d pixel = camera.project(in_camera);
    if (!silhouette.sees(pixel.x(), pixel.y())) continue;
    Look& look = looks[n];
    ++look.seen_by;
    const double distance = silhouette.distance_px(pixel.x(), pixel.y()) * in_camera.z() * metres_per_pixel_and_metre;
    look.distance_m = std::max(look.distance_m, static_cast<float>(std::min<double>(distance, band_m_)));
  }
}

}  // namespace scanknit
