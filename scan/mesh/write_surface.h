// Writes a surface to mesh files and pictures.
#pragma once

#include <optional>
#include <vector>

#include "core/axes.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/picture/surface_fit.h"
#include "extract/extract_surface.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// kMesh, with the most likely reason.
[[nodiscard]] Error empty_mesh_error(const ScanJob& job);

/// What a mesh's coordinates mean.
struct MeshFrame {
  UpAxis world_up;
  std::optional<Pose> T_world_scanner;  ///< pose of a frame in the middle of the scan: the viewpoint of pictures
  std::optional<double> file_unit_m;    ///< metres per unit of a volume file's own coordinates; nothing: a scan, metres
  std::vector<PosedDepth> depths = {};  ///< some of the frames that the mesh was made of
};

/// Checks the surface and writes the job's mesh files, then its pictures. Fills `result` as far as it came, also after
/// an error. Errors: kMesh when the surface is empty; kOutput.
[[nodiscard]] Result<void> write_surface(const Surface& surface, const MeshFrame& frame, const ScanJob& job,
                                         ScanSession& session, MeshResult& result);

/// Warns if the meshes of the chosen decider have holes by design.
void warn_of_holes(const ExtractConfig& config, ScanSession& session);

}  // namespace scanknit
