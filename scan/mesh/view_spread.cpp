#include "scan/mesh/view_spread.h"

#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "scan/mesh/cell_place.h"

namespace scanknit {
namespace {

/// Side of the patches of a picture whose readings are averaged. A voxel, too, sees several pixels of a view.
constexpr int kPatch = 4;
constexpr double kBandSigmas = 3, kBandVoxels = 2;
/// Distances of pixels, as shares of the picture's width, in steps.
constexpr int kSteps = 24;
constexpr double kLongestShare = 1.2;
/// A step needs so many pairs, and this share of all: few pairs are from corner to corner, where lenses are at their
/// worst.
constexpr double kFewestPairs = 100, kLeastShare = 0.01;
/// Surfaces that turn away from each other are not the same place.
constexpr float kSameNormal = 0.9f;
constexpr std::size_t kPlacesOfAFrame = 1000;

int step_of(double share) {
  return std::min(static_cast<int>(share * kSteps / kLongestShare), kSteps - 1);
}

}  // namespace

/// gamma: never falls with the distance, so that noise in few pairs makes no covariance.
struct ViewSpread::Variogram {
  std::array<double, kSteps> sum{}, pairs{}, gamma{};

  /// Pool adjacent violators (Ayer et al. 1955). Steps with too few pairs get what lies before them. False without any.
  bool fit() {
    struct Pool {
      double sum, pairs;
      int end;
    };
    const double fewest = std::max(kFewestPairs, kLeastShare * std::accumulate(pairs.begin(), pairs.end(), 0.0));
    std::vector<Pool> pools;
    for (int i = 0; i < kSteps; ++i) {
      if (pairs[i] < fewest) continue;
      pools.push_back({sum[i], pairs[i], i + 1});
      while (pools.size() > 1) {
        Pool& last = pools.back();
        Pool& before = pools[pools.size() - 2];
        if (before.sum * last.pairs <= last.sum * before.pairs) break;
        before = {before.sum + last.sum, before.pairs + last.pairs, last.end};
        pools.pop_back();
      }
    }
    if (pools.empty()) return false;
    std::size_t pool = 0;
    for (int i = 0; i < kSteps; ++i) {
      if (i >= pools[pool].end && pool + 1 < pools.size()) ++pool;
      gamma[i] = pools[pool].sum / pools[pool].pairs;
    }
    return true;
  }
  [[nodiscard]] double sill() const { return gamma.back(); }
  [[nodiscard]] double covariance(double share) const { return sill() - gamma[step_of(share)]; }
};

ViewSpread::ViewSpread(std::span<const PosedDepth> frames, const NoiseModel& noise)
    : frames_(frames), noise_(noise), patches_(frames.size()) {
  for (std::size_t i = 0; i < frames.size(); ++i) patches_[i].resize(columns(i) * rows(i));
}

std::size_t ViewSpread::columns(std::size_t frame) const {
  return static_cast<std::size_t>(frames_[frame].depth_m->width() / kPatch);
}

std::size_t ViewSpread::rows(std::size_t frame) const {
  return static_cast<std::size_t>(frames_[frame].depth_m->height() / kPatch);
}

void ViewSpread::add(const FieldView& view, int begin_x, int end_x) {
  const openvdb::math::Transform& transform = view.field->transform();
  const double voxel_m = view.field->voxelSize().x();
  voxel_size_m_ = static_cast<float>(voxel_m);
  tbb::parallel_for(std::size_t{0}, frames_.size(), [&](std::size_t f) {
    const PosedDepth& frame = frames_[f];
    const auto samples = view.field->getConstAccessor();
    for (std::size_t row = 0; row < rows(f); ++row) {
      for (std::size_t column = 0; column < columns(f); ++column) {
        const int u = static_cast<int>(column) * kPatch, v = static_cast<int>(row) * kPatch;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        int readings = 0;
        for (int pixel = 0; pixel < kPatch * kPatch; ++pixel) {
          const int x = u + pixel % kPatch, y = v + pixel / kPatch;
          const auto z_m = static_cast<double>(frame.depth_m->at(x, y));
          if (!(z_m > 0)) break;
          const Eigen::Vector3d p_camera = frame.intrinsics.unproject(x, y, z_m);
          const auto distance_m = distance_at(samples, CellPlace(transform, frame.T_world_camera * p_camera));
          const double band_m = std::max(kBandVoxels * voxel_m, kBandSigmas * noise_.sigma_m(z_m));
          if (!distance_m || std::abs(*distance_m) > band_m) break;
          sum += p_camera;
          ++readings;
        }
        if (readings < kPatch * kPatch) continue;
        const Eigen::Vector3d p_camera = sum / readings;
        const Eigen::Vector3d p_world = frame.T_world_camera * p_camera;
        const CellPlace place(transform, p_world);
        if (place.low.x() < begin_x || place.low.x() >= end_x) continue;
        const auto normal = normal_at(samples, transform, p_world);
        if (!normal) continue;
        const double facing = -normal->dot(frame.T_world_camera.linear() * p_camera.normalized());
        if (!(facing > 0)) continue;
        patches_[f][row * columns(f) + column] = {p_world.cast<float>(), normal->cast<float>(),
                                                  static_cast<float>(noise_.sigma_m(p_camera.z())),
                                                  static_cast<float>(facing), weight_at(view, place)};
      }
    }
  });
}

const ViewSpread::Patch* ViewSpread::same_place(const Patch& patch, std::size_t frame, Eigen::Vector2d& pixel) const {
  const PosedDepth& other = frames_[frame];
  const Eigen::Vector3d p_camera = other.T_world_camera.inverse() * patch.p_world.cast<double>();
  if (!(p_camera.z() > 0)) return nullptr;
  pixel = other.intrinsics.project(p_camera);
  const double column = std::floor((pixel.x() + 0.5) / kPatch), row = std::floor((pixel.y() + 0.5) / kPatch);
  if (!(column >= 0 && row >= 0 && column < static_cast<double>(columns(frame)) &&
        row < static_cast<double>(rows(frame))))
    return nullptr;
  const Patch& there =
      patches_[frame][static_cast<std::size_t>(row) * columns(frame) + static_cast<std::size_t>(column)];
  if (!(there.sigma_m > 0) || there.normal.dot(patch.normal) < kSameNormal) return nullptr;
  const float band_m = std::max(static_cast<float>(kBandVoxels) * voxel_size_m_,
                                static_cast<float>(kBandSigmas) * std::hypot(patch.sigma_m, there.sigma_m));
  if (std::abs(patch.normal.dot(patch.p_world - there.p_world)) > band_m) return nullptr;  // another surface
  return &there;
}

ViewSpread::Variogram ViewSpread::measure() const {
  std::vector<Variogram> parts(frames_.size());
  tbb::parallel_for(std::size_t{0}, frames_.size(), [&](std::size_t f) {
    for (std::size_t i = 0; i < patches_[f].size(); ++i) {
      const Patch& patch = patches_[f][i];
      if (!(patch.sigma_m > 0)) continue;
      const Eigen::Vector2d here =
          frames_[f].intrinsics.project(frames_[f].T_world_camera.inverse() * patch.p_world.cast<double>());
      for (std::size_t other = 0; other < frames_.size(); ++other) {
        Eigen::Vector2d pixel;
        const Patch* there = other == f ? nullptr : same_place(patch, other, pixel);
        if (there == nullptr) continue;
        const double apart_m = static_cast<double>(patch.normal.dot(patch.p_world - there->p_world));
        const int step = step_of((pixel - here).norm() / frames_[other].depth_m->width());
        parts[f].sum[step] += 0.5 * apart_m * apart_m / static_cast<double>(patch.sigma_m * there->sigma_m);
        parts[f].pairs[step] += 1;
      }
    }
  });
  Variogram all;
  for (const Variogram& part : parts) {
    for (int i = 0; i < kSteps; ++i) {
      all.sum[i] += part.sum[i];
      all.pairs[i] += part.pairs[i];
    }
  }
  return all;
}

double ViewSpread::view_sigma_m() const {
  Variogram variogram = measure();
  if (!variogram.fit()) return noise_.floor_m;
  std::vector<std::vector<float>> parts(frames_.size());
  tbb::parallel_for(std::size_t{0}, frames_.size(), [&](std::size_t f) {
    struct View {
      Eigen::Vector2d pixel;
      double weight, sigma_m;
    };
    std::vector<View> views;
    const std::size_t stride = 1 + patches_[f].size() / kPlacesOfAFrame;
    for (std::size_t i = 0; i < patches_[f].size(); i += stride) {
      const Patch& patch = patches_[f][i];
      if (!(patch.sigma_m > 0 && patch.weight > 0)) continue;
      views.clear();
      for (std::size_t other = 0; other < frames_.size(); ++other) {
        Eigen::Vector2d pixel;
        const Patch* there = same_place(patch, other, pixel);
        if (there == nullptr) continue;
        const auto sigma_m = static_cast<double>(there->sigma_m);
        views.push_back({pixel / frames_[other].depth_m->width(),
                         static_cast<double>(there->facing) / (sigma_m * sigma_m), sigma_m});
      }
      double weights = 0, variance = 0;
      for (std::size_t a = 0; a < views.size(); ++a) {
        weights += views[a].weight;
        variance += views[a].weight * views[a].weight * views[a].sigma_m * views[a].sigma_m * variogram.sill();
        for (std::size_t b = 0; b < a; ++b) {
          variance += 2 * views[a].weight * views[b].weight * views[a].sigma_m * views[b].sigma_m *
                      variogram.covariance((views[a].pixel - views[b].pixel).norm());
        }
      }
      if (!(weights > 0)) continue;
      const double stated = noise_.floor_m * noise_.floor_m / static_cast<double>(patch.weight);
      parts[f].push_back(static_cast<float>(variance / (weights * weights) / stated));
    }
  });
  std::vector<float> factors;
  for (const auto& part : parts) factors.insert(factors.end(), part.begin(), part.end());
  if (static_cast<double>(factors.size()) < kFewestPairs) return noise_.floor_m;
  const auto middle = factors.begin() + static_cast<std::ptrdiff_t>(factors.size() / 2);
  std::nth_element(factors.begin(), middle, factors.end());
  return noise_.floor_m * std::sqrt(static_cast<double>(*middle));
}

}  // namespace scanknit
