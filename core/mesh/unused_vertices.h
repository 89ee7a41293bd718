// Vertices that no triangle uses.
#pragma once

#include "core/mesh.h"

namespace scanknit {

/// Removes the vertices without a triangle; the others keep their order.
void drop_unused_vertices(Mesh& mesh);

}  // namespace scanknit
