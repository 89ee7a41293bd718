// Finds the parts of a closed mesh that were never seen.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "finish/close_volume.h"

namespace scanknit {

/// For each triangle: 1 if its cell has a corner that was not seen. `mesh` was extracted from `closed`.
[[nodiscard]] std::vector<std::uint8_t> invented_triangles(const Mesh& mesh, const ClosedVolume& closed);

/// For each triangle of `before`: 1 if `after`, the mesh of the closed volume, has no triangle in its cell: it was
/// outside of the box, or was removed since.
[[nodiscard]] std::vector<std::uint8_t> triangles_left_out(const Mesh& before, const Mesh& after,
                                                           const ClosedVolume& closed);

struct PatchCount {
  std::size_t kept = 0, left_open = 0;
};

/// Removes the invented patches (triangles joined by edges) that do not close small holes: those whose bounding box has
/// a diagonal over `max_size_m`, that have a free edge, or that touch nothing that was seen. Removes their triangles
/// from `invented`, too. A manifold mesh stays manifold: splits vertices at which triangles meet by corners only.
PatchCount keep_small_patches(double max_size_m, Mesh& mesh, std::vector<std::uint8_t>& invented);

/// Removes the pieces of the mesh that were not seen at all, or that have fewer than `min_triangles`; from `invented`,
/// too.
void drop_invented_pieces(std::size_t min_triangles, Mesh& mesh, std::vector<std::uint8_t>& invented);

/// Gives this colour to vertices whose triangles are all invented. A mesh without colours becomes grey elsewhere.
void paint_invented(const std::vector<std::uint8_t>& invented, Rgb8 colour, Mesh& mesh);

/// The area of the triangles marked with 1.
[[nodiscard]] double area_m2(const Mesh& mesh, const std::vector<std::uint8_t>& triangles);

}  // namespace scanknit
