// Fins: what the collapse of edges leaves of a surface that has become flat.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// Removes pairs of coincident triangles with opposite orientation. Collapses leave such fins, and the edge at which a
/// fin is attached has four sides. The surface is the same without them. The order of the rest is unchanged.
void remove_fins(std::vector<Triangle>& triangles);

}  // namespace scanknit
