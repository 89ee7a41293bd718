// A finished mesh in pieces that a browser takes one by one.
#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// The same triangles, in order within each piece, of at most `most_triangles` (> 0) each; pieces are boxes halved
/// along their longest side, with their own copies of the vertices that they share. `mesh` is well formed.
[[nodiscard]] std::vector<Mesh> split_mesh(const Mesh& mesh, std::size_t most_triangles);

}  // namespace scanknit
