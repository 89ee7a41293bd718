// Extracts the surface of a volume as a mesh.
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

/// Disambiguated marching cubes (Lorensen & Cline 1987; the deciders of ExtractConfig). The mesh is manifold (except
/// with Decider::kLorensen), consistently oriented (counter-clockwise seen from outside), in world coordinates, and the
/// same bits for any number of threads. Skips cells with an unobserved or NaN corner, which leaves a boundary. Errors:
/// kMesh for more than 2^32 - 2 vertices; kBudget when memory runs out; kConfig for an unusable transform.
[[nodiscard]] Result<Surface> extract_surface(const FieldView& view, const ExtractConfig& config);

/// Refers to samples that the caller owns; NaN where nothing is known.
struct DenseView {
  const float* samples = nullptr;  ///< (i, j, k) at i + dims.x() (j + dims.y() k)
  Eigen::Vector3i dims = Eigen::Vector3i::Zero();
  Eigen::Affine3d T_world_ijk = Eigen::Affine3d::Identity();
};

/// The same for an array of samples. Ignores `min_weight` of the configuration.
[[nodiscard]] Result<Surface> extract_surface(const DenseView& volume, const ExtractConfig& config);

/// Error kConfig: a value that extraction cannot use; the message says why. extract_surface() calls it first.
[[nodiscard]] Result<void> check_extract_config(const ExtractConfig& config);

}  // namespace scanknit
