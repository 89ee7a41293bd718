// Extraction: a volume becomes a mesh.
#pragma once

#include <Eigen/Geometry>

#include "core/field_view.h"
#include "core/mesh.h"
#include "core/result.h"
#include "extract/cell/case_counts.h"
#include "extract/extract_config.h"

namespace scanknit {

/// What was extracted.
struct Surface {
  Mesh mesh;         ///< may be empty: the isovalue meets no observed cell
  CaseCounts cases;  ///< how its cells were resolved
};

/// Disambiguated marching cubes (Lorensen & Cline 1987; the deciders of ExtractConfig). The mesh is manifold (but for
/// Decider::kLorensen), consistently oriented (counter-clockwise seen from outside), in world coordinates, and the same
/// bits for any number of threads. Cells with an unobserved or NaN corner are skipped and leave a boundary.
/// Errors: kMesh when the mesh would pass 2^32 - 2 vertices; kBudget when memory runs out; kConfig for a transform that
/// cannot be used.
[[nodiscard]] Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config);

/// An array of samples that somebody else owns; NaN where nothing is known.
struct DenseView {
  const float* samples = nullptr;  ///< (i, j, k) at i + dims.x() (j + dims.y() k)
  Eigen::Vector3i dims = Eigen::Vector3i::Zero();
  Eigen::Affine3d T_world_ijk = Eigen::Affine3d::Identity();
};

/// The same for an array of samples. `min_weight` of the configuration has no meaning here.
[[nodiscard]] Result<Surface> extract_surface(const DenseView& volume, const ExtractConfig& config);

/// Error (kConfig): a value that extraction cannot work with, and why. extract_surface() asks this first.
[[nodiscard]] Result<void> check_extract_config(const ExtractConfig& config);

}  // namespace scanknit
