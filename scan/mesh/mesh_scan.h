// The mesh of a reconstruction, written to all files of a job.
#pragma once

#include "core/axes.h"
#include "core/result.h"
#include "scan/mesh/write_texture.h"
#include "scan/reconstruction.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// What becomes of a crop box that holds nothing of the mesh.
enum class EmptyCrop {
  kRefused,  ///< an error: the box can still be changed
  kIgnored,  ///< the whole mesh is written, with a warning: a scan is never lost
};

struct MeshRequest {
  const ScanJob& job;
  UpAxis world_up;
  const CropBox& crop;
  EmptyCrop empty_crop = EmptyCrop::kIgnored;
  std::stop_token stop = {};  ///< see FinishRequest
};

/// `result` tells as much as was found out, also after an error. Errors: kTooLittle before the first frame; kMesh where
/// there is no surface; kOutput.
[[nodiscard]] Result<WrittenMesh> mesh_scan(const Reconstruction& scan, const MeshRequest& request,
                                            ScanSession& session, MeshResult& result);

}  // namespace scanknit
