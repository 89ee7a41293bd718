// The holes of a mesh: the loops of its boundary.
#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct Hole {
  std::size_t edges = 0;
  double length_m = 0;  ///< length of its rim
};

/// One hole for each loop of edges with only one triangle, the longest rim first. The outer border of an open surface
/// is such a loop, too. If loops touch at a vertex, their division is arbitrary, but the sum of lengths is right. O(n
/// log n).
[[nodiscard]] std::vector<Hole> find_holes(const Mesh& mesh);

}  // namespace scanknit
