// The pieces of a mesh.
#pragma once

#include "core/mesh.h"
#include "core/mesh/disjoint_sets.h"

namespace scanknit {

/// Sets of vertices: vertices that triangles connect are in one set.
[[nodiscard]] inline DisjointSets pieces_of(const Mesh& mesh) {
  DisjointSets sets(mesh.positions_m.size());
  for (const Triangle& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  return sets;
}

}  // namespace scanknit
