#include "scan/mesh/vertex_uncertainty.h"

#include <openvdb/openvdb.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "core/check.h"

namespace scanknit {
namespace {

constexpr int kCorners = 8;

/// Side of the patches of a picture whose readings are averaged. A voxel, too, sees several pixels of a view.
constexpr int kPatch = 4;
constexpr std::size_t kLeastPatches = 100;
constexpr double kMedianOfNormal = 0.6745;  // of |x| / sigma
constexpr double kBandSigmas = 3, kBandVoxels = 2;

/// Views are not independent of each other, either: neighbouring views see a place through neighbouring pixels.
/// Measured on synthetic scans (docs/formats.md).
constexpr double kViewsAlike = 1.7;
/// What does not average out, of a voxel: the surface is linear between samples.
constexpr double kVoxelShare = 0.05;

float weight_of(float weight) {
  return std::isfinite(weight) ? std::max(weight, 0.0f) : 0.0f;
}

float weight_of(WeightCode code) {
  return decode_weight(code);
}

/// The cell that holds a point, and what each of its corners counts there.
struct CellPlace {
  CellPlace(const openvdb::math::Transform& transform, const Eigen::Vector3d& p_world) {
    const openvdb::Vec3d index = transform.worldToIndex(openvdb::Vec3d(p_world.x(), p_world.y(), p_world.z()));
    low = openvdb::Coord::floor(index);
    share = index - low.asVec3d();
  }
  [[nodiscard]] static openvdb::Coord offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }
  [[nodiscard]] double part(int corner) const {
    const openvdb::Coord at = offset(corner);
    double product = 1;
    for (int axis = 0; axis < 3; ++axis) product *= at[axis] != 0 ? share[axis] : 1 - share[axis];
    return product;
  }

  openvdb::Coord low;
  openvdb::Vec3d share;
};

template <typename Grid>
void raise_by(const Grid& grid, const Mesh& mesh, const Pose& T_world_mesh, std::vector<float>& weights) {
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, mesh.positions_m.size(), 4096), [&](const Range& range) {
    const auto samples = grid.getConstAccessor();
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const CellPlace place(grid.transform(), T_world_mesh * mesh.positions_m[v].cast<double>());
      double mean = 0;
      for (int corner = 0; corner < kCorners; ++corner) {
        const double part = place.part(corner);
        if (part > 0) mean += part * static_cast<double>(weight_of(samples.getValue(place.low + place.offset(corner))));
      }
      weights[v] = std::max(weights[v], static_cast<float>(mean));
    }
  });
}

/// The field at a point; nothing unless all corners of its cell were observed.
std::optional<double> distance_at(const openvdb::FloatGrid::ConstAccessor& samples, const CellPlace& place) {
  double mean = 0;
  for (int corner = 0; corner < kCorners; ++corner) {
    float value = 0;
    if (!samples.probeValue(place.low + place.offset(corner), value) || !std::isfinite(value)) return std::nullopt;
    mean += place.part(corner) * static_cast<double>(value);
  }
  return mean;
}

}  // namespace

void NoiseShare::add(const FieldView& view, int begin_x, int end_x) {
  const openvdb::FloatGrid& field = *view.field;
  const auto samples = field.getConstAccessor();
  const double least_band_m = kBandVoxels * field.voxelSize().x();
  for (const PosedDepth& frame : frames_) {
    for (int v = 0; v + kPatch <= frame.depth_m->height(); v += kPatch) {
      for (int u = 0; u + kPatch <= frame.depth_m->width(); u += kPatch) {
        double sum = 0;
        int readings = 0;
        for (int pixel = 0; pixel < kPatch * kPatch; ++pixel) {
          const int x = u + pixel % kPatch, y = v + pixel / kPatch;
          const auto z_m = static_cast<double>(frame.depth_m->at(x, y));
          if (!(z_m > 0)) break;
          const CellPlace place(field.transform(), frame.T_world_camera * frame.intrinsics.unproject(x, y, z_m));
          if (pixel == 0 && (place.low.x() < begin_x || place.low.x() >= end_x)) break;
          const auto distance_m = distance_at(samples, place);
          const double sigma_m = noise_.sigma_m(z_m);
          if (!distance_m || std::abs(*distance_m) > std::max(least_band_m, kBandSigmas * sigma_m)) break;
          sum += *distance_m / sigma_m;
          ++readings;
        }
        if (readings == kPatch * kPatch) shares_.push_back(static_cast<float>(std::abs(sum) / readings));
      }
    }
  }
}

double NoiseShare::value() {
  if (shares_.size() < kLeastPatches) return 1;
  const auto middle = shares_.begin() + static_cast<std::ptrdiff_t>(shares_.size() / 2);
  std::nth_element(shares_.begin(), middle, shares_.end());
  return static_cast<double>(*middle) / kMedianOfNormal;
}

void raise_weights(const Mesh& mesh, const Pose& T_world_mesh, const FieldView& view, std::vector<float>& weights) {
  SCANKNIT_CHECK(weights.size() == mesh.positions_m.size());
  if (view.weight != nullptr) raise_by(*view.weight, mesh, T_world_mesh, weights);
  if (view.weight_codes != nullptr) raise_by(*view.weight_codes, mesh, T_world_mesh, weights);
}

float uncertainty_m(float weight, const UncertaintyScale& scale) {
  if (!(weight > 0)) return std::numeric_limits<float>::quiet_NaN();
  const double noise_m = kViewsAlike * scale.view_sigma_m / std::sqrt(static_cast<double>(weight));
  return static_cast<float>(std::hypot(noise_m, kVoxelShare * scale.voxel_size_m));
}

std::vector<float> uncertainties_m(const std::vector<float>& weights, const UncertaintyScale& scale) {
  std::vector<float> sigmas_m(weights.size());
  std::transform(weights.begin(), weights.end(), sigmas_m.begin(),
                 [&](float weight) { return uncertainty_m(weight, scale); });
  return sigmas_m;
}

}  // namespace scanknit
