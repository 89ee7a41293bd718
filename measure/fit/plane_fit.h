// A plane through a part of a mesh.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

struct FittedPlane {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();  ///< of the surface that belongs to it
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();   ///< outwards
  double offset_m = 0;                                 ///< normal . p of its points
  double rms_m = 0;
  double min_m = 0, max_m = 0;  ///< how far the surface goes below it and above: their difference is its flatness
  double area_m2 = 0;
  double share = 0;  ///< of the surface near the point that belongs to it
};

/// Least squares, weighted by area, over the surface within `radius_m` of the point that faces within 30 degrees of
/// where the mesh faces at the point, without what is more than three deviations off. Errors (kTooLittle): there is no
/// surface, or too little.
[[nodiscard]] Result<FittedPlane> fit_plane(const Mesh& mesh, const Eigen::Vector3d& at_m, double radius_m);

}  // namespace scanknit
