// Vertices that no triangle uses.
#pragma once

#include "core/mesh.h"

namespace scanknit {

/// Drops them; the others keep their order.
void drop_unused_vertices(Mesh& mesh);

}  // namespace scanknit
