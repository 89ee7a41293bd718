#include "scan/mesh/vertex_uncertainty.h"

#include <openvdb/openvdb.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/check.h"
#include "scan/mesh/cell_place.h"

namespace scanknit {
namespace {

/// What does not average out, of a voxel: the surface is linear between samples.
constexpr double kVoxelShare = 0.05;
/// Samples and pixels round off what bends: the share of the bend. Measured on synthetic scans (docs/formats.md).
constexpr double kBendShare = 0.2;
constexpr double kBesideVoxels = 2;
constexpr int kDirections = 4;

/// VertexEvidence::bend_m. Where the field is not known to both sides, it does not count.
float bend_at(const openvdb::FloatGrid::ConstAccessor& samples, const openvdb::math::Transform& transform,
              const Eigen::Vector3d& p_world) {
  const auto normal = normal_at(samples, transform, p_world);
  const auto here = distance_at(samples, CellPlace(transform, p_world));
  if (!normal || !here) return 0;
  const Eigen::Vector3d across = normal->unitOrthogonal(), along = normal->cross(across);
  const double beside_m = kBesideVoxels * transform.voxelSize().x();
  double most_m = 0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = M_PI * i / kDirections;
    const Eigen::Vector3d step = beside_m * (std::cos(angle) * across + std::sin(angle) * along);
    const auto after = distance_at(samples, CellPlace(transform, p_world + step));
    const auto before = distance_at(samples, CellPlace(transform, p_world - step));
    if (after && before) most_m = std::max(most_m, std::abs((*after + *before) / 2 - *here));
  }
  return static_cast<float>(most_m);
}

}  // namespace

void add_evidence(const Mesh& mesh, const Pose& T_world_mesh, const FieldView& view, VertexEvidence& evidence,
                  int begin_x, int end_x) {
  SCANKNIT_CHECK(evidence.weight.size() == mesh.positions_m.size());
  const openvdb::math::Transform& transform = view.field->transform();
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, mesh.positions_m.size(), 4096), [&](const Range& range) {
    const auto samples = view.field->getConstAccessor();
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const Eigen::Vector3d p_world = T_world_mesh * mesh.positions_m[v].cast<double>();
      const CellPlace place(transform, p_world);
      if (place.low.x() < begin_x || place.low.x() >= end_x) continue;
      evidence.weight[v] = std::max(evidence.weight[v], weight_at(view, place));
      evidence.bend_m[v] = std::max(evidence.bend_m[v], bend_at(samples, transform, p_world));
    }
  });
}

float uncertainty_m(float weight, float bend_m, const UncertaintyScale& scale) {
  if (!(weight > 0)) return std::numeric_limits<float>::quiet_NaN();
  const double noise_m = scale.view_sigma_m / std::sqrt(static_cast<double>(weight));
  return static_cast<float>(
      std::hypot(noise_m, kVoxelShare * scale.voxel_size_m, kBendShare * static_cast<double>(bend_m)));
}

std::vector<float> uncertainties_m(const VertexEvidence& evidence, const UncertaintyScale& scale) {
  std::vector<float> sigmas_m(evidence.weight.size());
  for (std::size_t v = 0; v < sigmas_m.size(); ++v) {
    sigmas_m[v] = uncertainty_m(evidence.weight[v], evidence.bend_m[v], scale);
  }
  return sigmas_m;
}

}  // namespace scanknit
