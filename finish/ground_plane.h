// Finds the table or the floor that a scan stands on.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

struct GroundPlane {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< unit, out of the ground
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double area_m2 = 0;   ///< area of the mesh that lies on it
  double share = 0;     ///< share of the mesh's area that lies on it
  double rms_m = 0;     ///< of the centres of that part's triangles
  double tilt_rad = 0;  ///< angle to the expected up direction

  [[nodiscard]] double height_m(const Eigen::Vector3d& p) const { return up.dot(p - point); }
};

struct GroundSearch {
  Eigen::Vector3d expected_up = Eigen::Vector3d::UnitZ();  ///< unit
  double max_tilt_rad = 0.785398;  ///< excludes walls; includes a scanner that looked down by less than this
  double tolerance_m = 0.008;      ///< points nearer than this belong to the plane
  double min_share = 0.05;         ///< of the mesh's area
};

/// The plane with most of the mesh on it, by RANSAC (Fischler & Bolles 1981, PCL's), fitted again to the part on it.
/// Deterministic. Nothing when no plane is found, or when what stands on the plane reaches beyond it: then the plane is
/// a plinth, part of the object. Error (kInternal): the module for PCL is missing (finish/finish_pcl.h).
[[nodiscard]] Result<std::optional<GroundPlane>> find_ground(const Mesh& mesh, const GroundSearch& search);

}  // namespace scanknit
