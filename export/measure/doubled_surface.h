// Surface that is there twice: two sheets close to each other that face the same way.
#pragma once

#include "core/mesh.h"

namespace scanknit {

struct DoubledSurface {
  double area_m2 = 0;
  double share = 0;  ///< of the mesh's area
};

/// The area that has another sheet before or behind it, along its normal, at a distance of 1.5 to 6 times `voxel_m`,
/// that faces the same way within 37 degrees. Real surfaces do not lie like that, because something solid is between a
/// sheet and the next one of the same direction, but a wall that was fused at two wrong places does. Measured at
/// vertices, at most 200,000 of them, evenly spread. The mesh has normals, and vertices about as close as voxels: a
/// mesh as it was extracted. The same bits for any number of threads.
[[nodiscard]] DoubledSurface find_doubled_surface(const Mesh& mesh, double voxel_m);

}  // namespace scanknit
