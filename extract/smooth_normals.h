// Normals from the triangles, where the volume's gradient does not tell.
#pragma once

#include "core/mesh.h"

namespace scanknit {

/// Replaces every zero normal by the area-weighted mean of the normals of the triangles round the vertex; by +z where
/// that is zero as well. Every normal is then of length 1.
void fill_missing_normals(Mesh& mesh);

}  // namespace scanknit
