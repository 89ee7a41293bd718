// How thick the walls of a mesh are.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "core/mesh.h"
#include "measure/tree/triangle_bvh.h"

namespace scanknit {

/// Of points spread evenly over the area. Shares are of all points.
struct WallThickness {
  std::size_t points = 0;
  double share_measured = 0;  ///< of the others the ray left no wall: the mesh is open there, or sheets overlap
  double min_m = 0, p01_m = 0, p05_m = 0, median_m = 0, max_m = 0;
  Eigen::Vector3d thinnest_m = Eigen::Vector3d::Zero();  ///< where it is `min_m`
  std::optional<double> share_thin;                      ///< thinner than what was asked for
};

/// Follows a ray from each point inwards, against the triangle's normal, to where it leaves the wall. At a sharp edge
/// the thickness runs to zero. `tree` is of the mesh, which must be measurable; `is_inside_out` as MeshVolume has it.
/// The same bits for any number of threads.
[[nodiscard]] WallThickness measure_thickness(const Mesh& mesh, const TriangleBvh& tree, bool is_inside_out,
                                              std::optional<double> thin_m = std::nullopt,
                                              std::size_t points = 100'000);

}  // namespace scanknit
