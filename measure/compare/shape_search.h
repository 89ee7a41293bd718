// Finds where a mesh lies on a reference by their shapes alone.
#pragma once

#include "core/mesh.h"
#include "core/pose.h"

namespace scanknit {

struct ShapePlacement {
  Pose T_reference_mesh = Pose::Identity();
  /// Another placement, turned by more than 10 degrees, fits within 10 % as well: a symmetric shape, or too little of
  /// it.
  bool is_ambiguous = false;
};

/// Tries the 60 rotations of an icosahedron between the principal axes of both surfaces, with their centres of area
/// upon each other, improves the best of them, and returns the one whose surfaces lie closest to each other, both ways.
/// Each of the meshes must show most of the thing. Both must be measurable (check_measurable()). The same bits for any
/// number of threads.
[[nodiscard]] ShapePlacement find_by_shape(const Mesh& mesh, const Mesh& reference);

}  // namespace scanknit
