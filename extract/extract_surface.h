// Extracts the surface of a volume as a mesh.
#pragma once

#include <cstddef>

#include "core/field_view.h"
#include "core/mesh.h"
#include "core/result.h"
#include "extract/blocks/dense_blocks.h"
#include "extract/cell/case_counts.h"
#include "extract/extract_config.h"

namespace scanknit {

struct Surface {
  Mesh mesh;  ///< may be empty: the isovalue meets no observed cell
  CaseCounts cases;
};

/// Disambiguated marching cubes (Lorensen & Cline 1987; the deciders of ExtractConfig). The mesh is manifold (except
/// with Decider::kLorensen), consistently oriented (counter-clockwise seen from outside), in world coordinates, and the
/// same bits for any number of threads. Skips cells with an unobserved or NaN corner, which leaves a boundary. Errors:
/// kMesh for more than 2^32 - 2 vertices; kBudget when memory runs out; kConfig for an unusable transform.
[[nodiscard]] Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config);

/// The same for an array of samples. Ignores `min_weight` of the configuration.
[[nodiscard]] Result<Surface> extract_surface(const DenseView& volume, const ExtractConfig& config);

/// Error kConfig: a value that extraction cannot use; the message says why.
[[nodiscard]] Result<void> check_extract_config(const ExtractConfig& config);

[[nodiscard]] bool is_inside_high(InsideSide inside, bool is_signed_distance);

/// Indices are 32-bit, and GLB keeps the last value for itself.
inline constexpr std::size_t kMaxMeshVertices = 0xFFFFFFFEu;
[[nodiscard]] Error too_many_vertices();

}  // namespace scanknit
