// Meshes volumes larger than memory: reads a few slices at a time and passes the mesh on in parts.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>

#include "core/mesh.h"
#include "core/result.h"
#include "extract/cell/case_counts.h"
#include "extract/extract_config.h"
#include "extract/volume/slice_reader.h"

namespace scanknit {

/// Takes the next part of a mesh: its vertices, whose numbers continue those of the last part, and triangles whose
/// indices count from the first vertex of the first part. A triangle may use vertices of this part, earlier parts, and
/// the next part.
using MeshPartSink = std::function<Result<void>(const Mesh& part)>;

struct StreamedSurface {
  CaseCounts cases;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

/// Gives the same vertices and triangles, in the same order and bit for bit, as extract_surface() for the whole volume
/// in coordinates of `T_world_ijk`, except that vertices with a zero gradient have a zero normal, and small components
/// stay. Keeps in memory as many slices as a quarter of the configuration's `memory_budget_mib` allows (at least 26),
/// the data of their cells, and parts of the mesh of at most a quarter of the budget. Errors: those of the reader, the
/// sink and extract_surface; kConfig for a tetrahedral decider; kBudget when 26 slices need more than the whole budget.
[[nodiscard]] Result<StreamedSurface> stream_surface(SliceReader& reader, const Eigen::Affine3d& T_world_ijk,
                                                     const ExtractConfig& config, const MeshPartSink& sink);

}  // namespace scanknit
