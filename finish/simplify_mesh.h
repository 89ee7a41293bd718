// Reduces the number of triangles.
#pragma once

#include <cstddef>
#include <optional>

#include "core/mesh.h"

namespace scanknit {

struct SimplifyWish {
  std::optional<std::size_t> triangles;  ///< keep at least so many; nothing: as few as the error allows
  std::optional<double> max_error_m;     ///< nothing: no limit
};

struct MeshSimplified {
  std::size_t triangles_before = 0, triangles = 0;
  std::size_t pieces_lost = 0;
  double error_m = 0;  ///< quadric error: an estimate of how far the surface moved
  bool is_held_back =
      false;  ///< reaching the target would change the topology: at least 1 % more triangles than asked for are left
};

/// Collapses edges onto existing vertices (meshoptimizer), so that each remaining vertex keeps its position, normal and
/// colour. A manifold mesh stays manifold, and a closed one stays closed with the same genus, but small pieces may
/// vanish. Keeps the triangles whose collapse would break this; if these are too many, simplifies in steps as far as
/// possible. Deterministic.
MeshSimplified simplify_mesh(const SimplifyWish& wish, Mesh& mesh);

}  // namespace scanknit
