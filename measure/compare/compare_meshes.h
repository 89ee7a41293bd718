// compare_meshes: how far a mesh deviates from a reference.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/mesh.h"
#include "measure/compare/deviation_regions.h"
#include "measure/compare/deviation_stats.h"
#include "measure/tree/pseudonormals.h"

namespace scanknit {

struct MeshDeviation {
  std::vector<double> vertices_m;  ///< of each vertex of the mesh from the reference, in order
  DeviationStats vertices;
  DeviationStats area;                   ///< of points spread evenly over the mesh's area
  DeviationStats reference_area;         ///< of points spread evenly over the reference's area, from the mesh
  DeviationHistogram histogram;          ///< of `area`
  std::vector<DeviationRegion> regions;  ///< of `area`, by parts of the reference's bounding box
};

/// What lies beyond a tolerance, as shares from 0 to 1.
struct ToleranceShares {
  double vertices = 0, area = 0, reference_area = 0;
};

/// What makes signs doubtful.
struct SideNotes {
  EdgeCounts edges;
  bool is_inside_out = false;
};

struct ComparedMeshes {
  MeshDeviation deviation;
  SideNotes mesh, reference;
  std::optional<ToleranceShares> beyond;
};

/// Distances are exact, and positive outside of the other mesh (before its front, if it is open). The meshes are in one
/// frame, measurable (check_measurable()), and have no vertices without triangles (unused_vertices.h), which would
/// count. The same bits for any number of threads.
[[nodiscard]] ComparedMeshes compare_meshes(const Mesh& mesh, const Mesh& reference,
                                            std::optional<double> tolerance_m = std::nullopt,
                                            std::size_t area_points = 200'000);

}  // namespace scanknit
