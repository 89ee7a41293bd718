// Fewer triangles.
#pragma once

#include <cstddef>
#include <optional>

#include "core/mesh.h"

namespace scanknit {

struct SimplifyWish {
  std::optional<std::size_t> triangles;  ///< at least so many stay; nothing: as few as the error allows
  std::optional<double> max_error_m;     ///< nothing: whatever it takes
};

struct MeshSimplified {
  std::size_t triangles_before = 0, triangles = 0;
  std::size_t pieces_lost = 0;
  double error_m = 0;  ///< of the quadrics; an estimate of how far the surface moved
  bool is_held_back =
      false;  ///< the wish would have broken the topology: there is a hundredth more triangles than asked for, or more
};

/// meshoptimizer's edge collapses onto vertices that are there, so that each vertex keeps its place, normal and colour.
/// What was manifold stays so, closed stays closed with all its rings, but small pieces may vanish. What would break
/// this is kept as it was; where that is too much, the mesh is simplified in steps, as far as they go. Deterministic.
MeshSimplified simplify_mesh(const SimplifyWish& wish, Mesh& mesh);

}  // namespace scanknit
