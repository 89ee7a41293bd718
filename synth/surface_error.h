// Surface error: the distance of a mesh from the exact surface, and the share of the surface that it covers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "synth/scene/scene.h"
#include "synth/scene/surface_samples.h"

namespace scanknit {

/// Statistics of unsigned distances, metres; shares are 0 to 1.
struct DistanceStats {
  std::size_t count = 0;
  double mean_m = 0;
  double rms_m = 0;
  double median_m = 0;
  double p95_m = 0;
  double max_m = 0;
  double share_within_1mm = 0;
  double share_within_5mm = 0;
};

struct SurfaceError {
  DistanceStats vertices;      ///< accuracy: mesh vertices to the exact surface
  DistanceStats area;          ///< accuracy: points spread evenly over the mesh's area to the exact surface
  DistanceStats completeness;  ///< visible truth points to the mesh
  double share_complete = 0;   ///< share of the visible truth points within `threshold_m` of the mesh
  double threshold_m = 0;
};

struct SurfaceErrorConfig {
  std::size_t area_samples = 200'000;
  double threshold_m = 0.010;  ///< a truth point this near the mesh counts as reconstructed
};

/// Registers a mesh, near the surface at `start`, with the surface and returns T_truth_mesh. Point to plane, on
/// vertices spread over the mesh (Chen & Medioni 1991). The same bits for any number of threads.
[[nodiscard]] Pose fit_to_surface(const Mesh& mesh, const SyntheticScene& scene, const Pose& start);

/// The mesh is in the recording's world, metres. The same bits for any number of threads. Error kMesh: no triangles, an
/// index out of range, a number that is not finite, or no area.
[[nodiscard]] Result<SurfaceError> measure_surface(const Mesh& mesh, const SyntheticScene& scene,
                                                   const std::vector<TruthPoint>& visible,
                                                   const SurfaceErrorConfig& config = {});

/// The same against the truth files of a synthetic recording. Errors (kInput): as read_truth.
[[nodiscard]] Result<SurfaceError> measure_surface(const Mesh& mesh, const std::filesystem::path& truth_folder,
                                                   const SurfaceErrorConfig& config = {});

}  // namespace scanknit
