// Points spread evenly over the area of a mesh.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

struct AreaPoint {
  Eigen::Vector3d position_m;
  std::uint32_t triangle = 0;
};

/// Divides the mesh's area, in the order of its triangles, into `count` equal shares, and draws one point in each: the
/// same points for the same mesh. Empty when the mesh has no area. The mesh must be well formed.
[[nodiscard]] std::vector<AreaPoint> spread_over_area(const Mesh& mesh, std::size_t count);

[[nodiscard]] std::vector<Eigen::Vector3d> positions_of(const std::vector<AreaPoint>& points);

/// Errors (kMesh): no triangles, an index out of range, a number that is not finite, no area.
[[nodiscard]] Result<void> check_measurable(const Mesh& mesh);

}  // namespace scanknit
