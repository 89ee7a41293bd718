// Volumes larger than memory: read a few slices at a time, the mesh handed on in parts.
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

/// Takes the next part of a mesh: its vertices, numbered on from the last part's, and triangles whose indices count
/// from the very first vertex. A triangle may use vertices of this part, of the ones before, and of the part to come.
using MeshPartSink = std::function<Result<void>(const Mesh& part)>;

struct StreamedSurface {
  CaseCounts cases;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

/// The same vertices and triangles, in the same order and to the bit, as extract_surface gives for the whole volume in
/// coordinates of `T_world_ijk`; but vertices whose gradient vanishes have a zero normal, and small components stay.
/// Holds as many slices as a quarter of `memory_budget_mib` of the configuration allows, 26 at least, what is known of
/// their cells, and parts of the mesh of at most a quarter of the budget. Errors: those of the reader, the sink and
/// extract_surface; kConfig for a tetrahedral decider; kBudget when 26 slices need more than the whole budget.
[[nodiscard]] Result<StreamedSurface> stream_surface(SliceReader& reader, const Eigen::Affine3d& T_world_ijk,
                                                     const ExtractConfig& config, const MeshPartSink& sink);

}  // namespace scanknit
