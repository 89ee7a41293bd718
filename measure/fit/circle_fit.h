// A circle: the cross section of a round hole or rod in a mesh.
#pragma once

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

struct FittedCircle {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< on the axis, amid the wall
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double radius_m = 0;
  double rms_m = 0;      ///< of the wall's distance from the cylinder
  bool is_hole = false;  ///< the wall faces the axis
  double arc_rad = 0;    ///< how far the wall goes round
  double wall_area_m2 = 0;
  double share = 0;  ///< of the surface near the point that belongs to it
};

/// Looks within `radius_m` of the point for the wall of a cylinder (RANSAC over pairs of places and normals, as
/// Schnabel et al. 2007), then least squares. A wall of flat facets is measured at their middles: of n facets, the
/// radius is less by up to 3.3 / n^2. Errors (kTooLittle): no wall that goes round by 60 degrees. The same bits every
/// time.
[[nodiscard]] Result<FittedCircle> fit_circle(const Mesh& mesh, const Eigen::Vector3d& at_m, double radius_m);

}  // namespace scanknit
