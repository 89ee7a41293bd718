#include "scan/mesh/cell_place.h"

#include <algorithm>
#include <cmath>

namespace scanknit {
namespace {

float weight_of(float weight) {
  return std::isfinite(weight) ? std::max(weight, 0.0f) : 0.0f;
}

float weight_of(WeightCode code) {
  return decode_weight(code);
}

template <typename Grid>
float mean_weight(const Grid& grid, const CellPlace& place) {
  const auto samples = grid.getConstUnsafeAccessor();
  double mean = 0;
  for (int corner = 0; corner < CellPlace::kCorners; ++corner) {
    const double part = place.part(corner);
    if (part > 0) mean += part * static_cast<double>(weight_of(samples.getValue(place.low + place.offset(corner))));
  }
  return static_cast<float>(mean);
}

}  // namespace

CellPlace::CellPlace(const openvdb::math::Transform& transform, const Eigen::Vector3d& p_world) {
  const openvdb::Vec3d index = transform.worldToIndex(openvdb::Vec3d(p_world.x(), p_world.y(), p_world.z()));
  low = openvdb::Coord::floor(index);
  share = index - low.asVec3d();
}

double CellPlace::part(int corner) const {
  const openvdb::Coord at = offset(corner);
  double product = 1;
  for (int axis = 0; axis < 3; ++axis) product *= at[axis] != 0 ? share[axis] : 1 - share[axis];
  return product;
}

std::optional<double> distance_at(const openvdb::FloatGrid::ConstAccessor& samples, const CellPlace& place) {
  double mean = 0;
  for (int corner = 0; corner < CellPlace::kCorners; ++corner) {
    float value = 0;
    if (!samples.probeValue(place.low + place.offset(corner), value) || !std::isfinite(value)) return std::nullopt;
    mean += place.part(corner) * static_cast<double>(value);
  }
  return mean;
}

std::optional<Eigen::Vector3d> normal_at(const openvdb::FloatGrid::ConstAccessor& samples,
                                         const openvdb::math::Transform& transform, const Eigen::Vector3d& p_world) {
  Eigen::Vector3d gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(axis) * transform.voxelSize().x();
    const auto after = distance_at(samples, CellPlace(transform, p_world + step));
    const auto before = distance_at(samples, CellPlace(transform, p_world - step));
    if (!after || !before) return std::nullopt;
    gradient[axis] = *after - *before;
  }
  const double length = gradient.norm();
  if (!(length > 0)) return std::nullopt;
  return gradient / length;
}

float weight_at(const FieldView& view, const CellPlace& place) {
  if (view.weight != nullptr) return mean_weight(*view.weight, place);
  return view.weight_codes != nullptr ? mean_weight(*view.weight_codes, place) : 0;
}

}  // namespace scanknit
