// Marching tetrahedra, to compare with: no ambiguity, but more triangles and another topology than the trilinear one.
#pragma once

#include "core/mesh.h"
#include "core/result.h"
#include "extract/blocks/block.h"
#include "extract/extract_config.h"
#include "extract/reference/tetrahedra.h"

namespace scanknit {

/// The isosurface of the piecewise linear function on the tetrahedra of every cell whose eight samples are observed.
/// Face points and centres take the mean of their corners; a value >= isovalue is High there as well.
///
/// A vertex's identity is its tetrahedron's edge. Linear placement keeps it inside that edge, at a distance from the
/// ends that survives rounding to float up to 2^18 voxels from the origin. Pinched vertices are split. Hence the mesh
/// is manifold, and bounded only where the observed cells are. k5 and k6 prefer some diagonals: turning the volume may
/// change their topology; k24 has no such direction.
///
/// `isovalue`: finite, in the volume's unit. Triangles are counter-clockwise seen from the Lows when `inside_is_high`,
/// else from the Highs. `normals`: the area-weighted mean of the triangles' round each vertex. No colours. One thread;
/// besides the mesh some 100 bytes for each vertex in a plane between blocks, and what split_pinched_vertices takes.
/// Error: kMesh past 2^32 - 2 vertices. Throws std::bad_alloc.
[[nodiscard]] Result<Mesh> march_tetrahedra(const BlockSource& source, TetraSplit split, double isovalue,
                                            VertexPlacement placement, bool inside_is_high, bool normals);

}  // namespace scanknit
