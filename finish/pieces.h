// Floaters: pieces of a mesh that are too small to be part of the object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

struct PiecesRemoved {
  std::size_t pieces = 0, triangles = 0;
  double area_m2 = 0;
};

/// Removes the pieces (triangles joined by vertices) whose area is less than `min_share` of the largest one's, or whose
/// bounding box has a diagonal below `min_size_m`. The largest piece stays. The order of the rest is unchanged.
PiecesRemoved remove_small_pieces(double min_share, double min_size_m, Mesh& mesh);

/// What a mesh loses without the triangles marked with 1: these triangles, their area, and the pieces that vanish
/// completely.
[[nodiscard]] PiecesRemoved count_removed(const Mesh& mesh, const std::vector<std::uint8_t>& is_left_out);

}  // namespace scanknit
