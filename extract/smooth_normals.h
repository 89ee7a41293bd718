// Normals from the triangles, for vertices without a usable gradient.
#pragma once

#include "core/mesh.h"

namespace scanknit {

/// Replaces every zero normal by the area-weighted mean of the normals of the vertex's triangles, or by +z if that is
/// zero as well. All normals then have length 1.
void fill_missing_normals(Mesh& mesh);

}  // namespace scanknit
