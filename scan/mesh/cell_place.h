// What a volume says at a point between its samples.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Core>
#include <optional>

#include "core/field_view.h"

namespace scanknit {

/// The cell that holds a point, and what each of its corners counts there.
struct CellPlace {
  static constexpr int kCorners = 8;

  CellPlace(const openvdb::math::Transform& transform, const Eigen::Vector3d& p_world);
  [[nodiscard]] static openvdb::Coord offset(int corner) { return {corner & 1, corner >> 1 & 1, corner >> 2}; }
  [[nodiscard]] double part(int corner) const;

  openvdb::Coord low;
  openvdb::Vec3d share;
};

/// The trilinear field; nothing unless all corners of the cell were observed.
[[nodiscard]] std::optional<double> distance_at(const openvdb::FloatGrid::ConstAccessor& samples,
                                                const CellPlace& place);

/// The field's direction of increase, unit; nothing where a cell beside the point was not observed, or it is flat.
[[nodiscard]] std::optional<Eigen::Vector3d> normal_at(const openvdb::FloatGrid::ConstAccessor& samples,
                                                       const openvdb::math::Transform& transform,
                                                       const Eigen::Vector3d& p_world);

/// The trilinear mean of the weights of the cell's samples, of which those that were not observed count 0; 0 for a view
/// without weights.
[[nodiscard]] float weight_at(const FieldView& view, const CellPlace& place);

}  // namespace scanknit
