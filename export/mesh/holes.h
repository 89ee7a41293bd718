// The holes of a mesh: the loops of its boundary.
#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct Hole {
  std::size_t edges = 0;
  double length_m = 0;  ///< of its rim
};

/// One for each loop of edges that belong to one triangle only, longest rim first. The outer border of an open surface
/// is such a loop, too. Where two loops touch at a vertex they are told apart somehow, with the right sum. O(n log n).
[[nodiscard]] std::vector<Hole> find_holes(const Mesh& mesh);

}  // namespace scanknit
