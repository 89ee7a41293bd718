// Vertices that no triangle uses, and memory that the mesh does not use.
#pragma once

#include "core/mesh.h"

namespace scanknit {

/// Removes the vertices without a triangle; the others keep their order.
void drop_unused_vertices(Mesh& mesh);

/// Gives back the memory of vertices and triangles that were removed, if they were many.
void return_unused_memory(Mesh& mesh);

}  // namespace scanknit
