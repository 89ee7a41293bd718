// From a volume to the surface that is written: extraction, and the steps of `finish:` before and after it.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/axes.h"
#include "core/field_view.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/picture/surface_fit.h"
#include "extract/extract_surface.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct FinishRequest {
  const ScanConfig& config;
  UpAxis world_up;             ///< the up axis unless export.world_up gives another
  double metres_per_unit = 1;  ///< of the surface's coordinates
  /// A stop request during the call skips the remaining steps, which get it as their reason. A request before the call
  /// has no effect: it is the normal end of a scan.
  std::stop_token stop = {};
  std::span<const PosedDepth> frames = {};  ///< of the scan, evenly spread: they confirm pieces of the mesh
  /// What the volume's weights are inverse variances of: the standard deviation of a view of weight 1, metres. Without
  /// it the weights are of another kind, and vertices get no uncertainty.
  std::optional<double> view_sigma_m = {};
  /// Called when a mesh that is not empty has been made and the volume is not read again: it may be freed here, before
  /// the steps that take the mesh alone. Not called when vertices get their uncertainty, which is read after these.
  std::function<void()> on_volume_read = {};
  int coarseness = 1;  ///< voxels of the scan (fusion.voxel_size) in one of the view, along an axis
};

/// The surface to be written. After an error, what was made before it.
struct FinishedSurface {
  Result<void> outcome;
  Surface surface;
  std::optional<FinishResult> steps;      ///< nothing unless `finish:` asks for a step
  std::vector<ScanWarning> warnings;      ///< the observer has been told of them
  std::vector<float> uncertainty_m = {};  ///< of each vertex; empty unless export.uncertainty asks for it and
                                          ///< FinishRequest::view_sigma_m is known

  /// From the volume's world to the mesh's coordinates.
  [[nodiscard]] Pose T_mesh_world() const { return steps ? steps->T_mesh_world : Pose::Identity(); }
};

/// Extracts the surface of a volume and finishes it; without `finish:` the same as extract_surface(). Skips a step that
/// cannot be done, and gives the reason in `steps` and as a warning, so that a scan is never lost. Where the volume is
/// too large to be closed, or its mesh to be simplified, in the memory that volume and mesh leave of
/// fusion.memory_budget, finishes a volume of larger voxels (finish/coarse_volume.h), with a warning. `outcome`: errors
/// of extract_surface(); kConfig for steps that exclude each other or do not apply to this volume.
[[nodiscard]] FinishedSurface finished_surface(const FieldView& view, const FinishRequest& request,
                                               ScanSession& session);

/// The same for a mesh that was extracted from a volume without distances: steps that need distances are errors
/// (kConfig).
[[nodiscard]] FinishedSurface finished_mesh(Surface surface, const FinishRequest& request, ScanSession& session);

/// kConfig if `config` asks for any step: a streamed mesh is never in memory as a whole.
[[nodiscard]] Result<void> refuse_to_finish_streamed(const FinishConfig& config);

}  // namespace scanknit
