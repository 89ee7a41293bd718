// Deviations of the parts of a thing, for a table.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "measure/compare/deviation_stats.h"

namespace scanknit {

/// One part of the reference's bounding box.
struct DeviationRegion {
  Eigen::AlignedBox3d box_m;
  double area_share = 0;         ///< of the mesh's area, from 0 to 1
  DeviationStats area;           ///< of the points in it
  std::optional<double> beyond;  ///< the share of its area beyond the tolerance, if there is one
};

/// Parts along each axis.
inline constexpr int kRegionsPerAxis = 3;

/// Divides `box_m` (not empty) into kRegionsPerAxis^3 equal parts, x fastest. Points beyond the box count in the
/// nearest part. Parts without a point are left out. points_m and distances_m are of one length.
[[nodiscard]] std::vector<DeviationRegion> deviation_regions(std::span<const Eigen::Vector3d> points_m,
                                                             std::span<const double> distances_m,
                                                             const Eigen::AlignedBox3d& box_m,
                                                             std::optional<double> tolerance_m);

}  // namespace scanknit
