// The table or the floor that a scan stands on.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

struct GroundPlane {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< unit, out of the ground
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double area_m2 = 0;   ///< of the mesh that lies on it
  double share = 0;     ///< of the mesh's area
  double rms_m = 0;     ///< of the middles of that part's triangles
  double tilt_rad = 0;  ///< against the up that was expected

  [[nodiscard]] double height_m(const Eigen::Vector3d& p) const { return up.dot(p - point); }
};

struct GroundSearch {
  Eigen::Vector3d expected_up = Eigen::Vector3d::UnitZ();  ///< unit
  double max_tilt_rad = 0.785398;  ///< walls are beyond it, and a scanner that looked down by less than that is within
  double tolerance_m = 0.008;      ///< points nearer than this are of the plane
  double min_share = 0.05;         ///< of the mesh's area
};

/// The plane with most of the mesh on it, by RANSAC (Fischler & Bolles 1981, PCL's), fitted once more to what lies on
/// it; the same for the same mesh. Nothing where the search finds none, or where what stands on the plane reaches
/// beyond it: that would be a plinth, and part of a thing. Error (kInternal): the module for PCL is missing
/// (finish/finish_pcl.h).
[[nodiscard]] Result<std::optional<GroundPlane>> find_ground(const Mesh& mesh, const GroundSearch& search);

}  // namespace scanknit
