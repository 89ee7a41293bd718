// A baked texture in the GLB: the colour frames of the scan are read once more.
#pragma once

#include <optional>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"
#include "scan/trajectory.h"

namespace scanknit {

/// A mesh that has been written, and where the frames stood that it was made of. Empty unless a texture is wanted.
struct WrittenMesh {
  Mesh mesh;
  UpAxis world_up = UpAxis::kMinusY;
  PosesBySequence T_mesh_camera;
};

/// Writes the job's GLB files anew, with a texture in the place of the vertices' colours, when the job asks for it.
/// When there can be none, they stay as they are; the reason is in `result` and a warning: a scan is never lost.
/// Errors: kOutput.
[[nodiscard]] Result<void> write_textured(const WrittenMesh& written, const ScanJob& job, const FrameArchive& archive,
                                          ScanSession& session, std::optional<TextureResult>& result);

/// kConfig if a texture is wanted of a `command` that has no frames to take it from.
[[nodiscard]] Result<void> refuse_texture(const ScanConfig& config, const char* command);

}  // namespace scanknit
