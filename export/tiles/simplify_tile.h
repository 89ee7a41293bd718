// Simplifies the surface of a tile, but not where other tiles meet it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct CoarseTile {
  std::vector<Triangle> triangles;  ///< of the mesh's vertices
  double error = 0;  ///< distance to the triangles that were given, in the mesh's unit; colours count, see there
};

/// Collapses edges until about `target` of the `fine` triangles are left, or as far as it goes. Vertices that are kept
/// stay where they are, and those for which `is_locked` holds are kept with all of the border between two of them: what
/// meets the fine triangles there without a gap meets the coarse ones. Where the mesh has normals and colours, black
/// instead of white counts as an error of half the mean edge. Never leaves none: rather all.
[[nodiscard]] CoarseTile simplify_tile(const Mesh& mesh, std::vector<Triangle> fine, std::size_t target,
                                       const std::function<bool(std::uint32_t)>& is_locked);

}  // namespace scanknit
