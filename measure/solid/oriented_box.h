// The smallest box round a mesh, turned as it may be.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"

namespace scanknit {

struct OrientedBox {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns, right-handed: along the longest side first
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();

  [[nodiscard]] double volume_m3() const { return size_m.prod(); }
};

/// Contains every vertex of a triangle. Of boxes that are smallest about each of their axes (Toussaint 1983, rotating
/// calipers), found from 60 directions and the principal axes, the smallest: mostly the smallest there is, and never
/// larger than that along the file's axes. The mesh must be well formed and not empty. The same bits for any number of
/// threads.
[[nodiscard]] OrientedBox find_oriented_box(const Mesh& mesh);

}  // namespace scanknit
