// The outline of a mesh in a plane.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// The points p with normal . p = offset_m. `right` and `up` are the axes of the drawing: right x up = normal, and the
/// drawing's coordinates are right . p and up . p.
struct SectionPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0;
  Eigen::Vector3d right = Eigen::Vector3d::UnitX(), up = Eigen::Vector3d::UnitY();
};

/// Looks against `normal`, a unit vector; the world's z is up in the drawing, or y where the normal is z.
[[nodiscard]] SectionPlane section_plane(const Eigen::Vector3d& normal, double offset_m);

struct Outline {
  std::vector<Eigen::Vector2d> points_m;  ///< a closed one does not repeat its first point
  bool is_closed = false;
  double length_m = 0;
  double area_m2 = 0;  ///< closed: positive round matter, negative round a hole in it; open: 0
};

struct MeshSection {
  SectionPlane plane;
  std::vector<Outline> outlines;  ///< the longest first
  double length_m = 0;            ///< of all
  double area_m2 = 0;             ///< of the matter within closed outlines
  std::size_t open_outlines = 0;
  Eigen::Vector2d min_m = Eigen::Vector2d::Zero(), max_m = Eigen::Vector2d::Zero();
};

/// One outline for each chain of triangles that the plane cuts; matter is to the left of it. Exact on the triangles. A
/// vertex that lies on the plane counts as above it. The mesh must be well formed.
[[nodiscard]] MeshSection cut_mesh(const Mesh& mesh, const SectionPlane& plane);

}  // namespace scanknit
