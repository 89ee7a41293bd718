// What of a closed mesh was never seen.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "finish/close_volume.h"

namespace scanknit {

/// For each triangle 1 where its cell has a corner that was not seen. `mesh` was extracted from `closed`.
[[nodiscard]] std::vector<std::uint8_t> invented_triangles(const Mesh& mesh, const ClosedVolume& closed);

/// For each triangle of `before` 1 where `after`, the mesh of the closed volume, has nothing in its cell: what lay
/// beyond the box, or was left out since.
[[nodiscard]] std::vector<std::uint8_t> triangles_left_out(const Mesh& before, const Mesh& after,
                                                           const ClosedVolume& closed);

struct PatchCount {
  std::size_t kept = 0, left_open = 0;
};

/// Removes the invented patches (triangles joined by edges) that are no small holes: their bounding box has a diagonal
/// over `max_size_m`, or they end in the open, or touch nothing that was seen; and from `invented` their triangles. A
/// manifold mesh stays manifold: vertices at which only corners meet are split.
PatchCount keep_small_patches(double max_size_m, Mesh& mesh, std::vector<std::uint8_t>& invented);

/// Removes the pieces of the mesh of which nothing was seen, or that have fewer than `min_triangles`. The same for
/// `invented`.
void drop_invented_pieces(std::size_t min_triangles, Mesh& mesh, std::vector<std::uint8_t>& invented);

/// Vertices all of whose triangles were invented get this colour. A mesh without colours becomes grey elsewhere.
void paint_invented(const std::vector<std::uint8_t>& invented, Rgb8 colour, Mesh& mesh);

/// The area of the triangles with a 1.
[[nodiscard]] double area_m2(const Mesh& mesh, const std::vector<std::uint8_t>& triangles);

}  // namespace scanknit
