// The stage that turns a volume into a mesh.
#pragma once

#include <array>
#include <cstddef>

#include "core/mesh.h"
#include "core/result.h"
#include "extract/extract_config.h"
#include "extract/field_view.h"

namespace scanknit {

/// How often each of the 15 configurations (0 to 14, the lecture's numbers) was met, and how ambiguous faces fell.
struct CaseCounts {
  std::array<std::size_t, 15> configuration{};  ///< [0] counts cells without surface in visited leaves
  std::size_t ambiguous_faces_joined = 0;       ///< the Highs are joined; a face of two cells counts twice
  std::size_t ambiguous_faces_separated = 0;
  std::size_t skipped_cells = 0;       ///< cells with observed High and Low corners and an unobserved one
  std::size_t components_removed = 0;  ///< by min_component_triangles
};

struct Surface {
  Mesh mesh;  ///< may be empty: the isovalue meets no observed cell
  CaseCounts cases;
};

/// Disambiguated marching cubes (Lorensen & Cline 1987; Nielson & Hamann 1991). The mesh is manifold, consistently
/// oriented (counter-clockwise seen from outside), in metres in the world frame, and the same bits for any number of
/// threads. Cells with an unobserved or NaN corner are skipped and leave a boundary.
/// Errors: kMesh when the mesh would pass 2^32 - 2 vertices; kBudget when memory runs out; kConfig for a transform that
/// is not uniform scale plus translation.
[[nodiscard]] Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config);

}  // namespace scanknit
