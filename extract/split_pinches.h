// Splits vertices where parts of a mesh touch in a point.
#pragma once

#include <cstddef>

#include "core/mesh.h"

namespace scanknit {

/// Two triangles at a vertex are of one fan when a chain of triangles at it, each sharing with the next an edge that
/// ends there, leads from one to the other. A vertex keeps the fan of its first triangle; each further fan gets a copy
/// with the same position, normal and colour. Copies are appended in the order of their vertices, then of their fans'
/// first triangles. Afterwards no vertex has more than one fan; triangles, edges and their order are unchanged.
///
/// Returns the number of copies. Linear in the mesh for bounded valence; takes 24 bytes for each vertex and triangle
/// meanwhile. The mesh is well formed. Indices wrap where the copies lead past 2^32 vertices: whoever comes near checks
/// the sizes afterwards. Throws std::bad_alloc.
std::size_t split_pinched_vertices(Mesh& mesh);

}  // namespace scanknit
