// From a volume to the surface that is written: extraction, and what `finish:` asks for before and after it.
#pragma once

#include <stop_token>

#include "core/axes.h"
#include "core/field_view.h"
#include "core/pose.h"
#include "core/result.h"
#include "extract/extract_surface.h"
#include "scan/scan_config.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

struct FinishRequest {
  const ScanConfig& config;
  UpAxis world_up;             ///< the way up unless export.world_up says otherwise
  double metres_per_unit = 1;  ///< of the surface's coordinates
  /// When it is asked for in the meantime, the remaining steps are not done, with that for their reason; a stop before
  /// is how a scan ends, and changes nothing.
  std::stop_token stop = {};
};

struct FinishedSurface {
  Surface surface;
  Pose T_mesh_world = Pose::Identity();  ///< from the volume's world to where the mesh stands
};

/// Extracts the surface of a volume and finishes it; without `finish:` it is extract_surface(). A step that cannot be
/// done is left out, with the reason in `result.finish` and as a warning: a scan is never lost. Errors:
/// extract_surface()'s; kConfig for steps that make no sense together or for this volume.
[[nodiscard]] Result<FinishedSurface> finished_surface(const FieldView& view, const FinishRequest& request,
                                                       ScanSession& session, MeshResult& result);

/// The same for a mesh that was extracted from a volume without distances: steps that need distances are errors
/// (kConfig).
[[nodiscard]] Result<FinishedSurface> finished_mesh(Surface surface, const FinishRequest& request, ScanSession& session,
                                                    MeshResult& result);

/// kConfig if anything is to be finished: a streamed mesh never is in memory as a whole.
[[nodiscard]] Result<void> refuse_to_finish_streamed(const FinishConfig& config);

}  // namespace scanknit
