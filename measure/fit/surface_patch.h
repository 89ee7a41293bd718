// The part of a mesh near a point, in small pieces.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct PatchPiece {
  Eigen::Vector3d middle_m;
  Eigen::Vector3d normal;  ///< unit, of its triangle
  double area_m2 = 0;
};

/// The triangles within `radius_m` of `centre_m`, cut into pieces of at most an eighth of that; those whose middle lies
/// beyond it are left out. At most about 20,000 pieces: of a finer mesh every n-th, with the area of n. The mesh must
/// be well formed.
[[nodiscard]] std::vector<PatchPiece> patch_round(const Mesh& mesh, const Eigen::Vector3d& centre_m, double radius_m);

}  // namespace scanknit
