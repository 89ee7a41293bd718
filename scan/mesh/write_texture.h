// Bakes a texture for the GLB: reads the colour frames of the scan once more.
#pragma once

#include <optional>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/result.h"
#include "scan/frames/frame_archive.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// A mesh that has been written, and the poses of the frames that it was made of. Empty unless a texture is wanted.
struct WrittenMesh {
  Mesh mesh;
  UpAxis world_up = UpAxis::kMinusY;
  PosesBySequence T_mesh_camera;
};

/// The texture of the written mesh. After an error, what was made before it.
struct TexturedMesh {
  Result<void> outcome;
  std::optional<TextureResult> texture;  ///< nothing unless the job asks for one
};

/// When the job asks for a texture, writes its GLB files again, with a texture instead of colours at the vertices. When
/// no texture can be made, the files stay as they are, and the result and a warning give the reason: a scan is never
/// lost. `outcome`: kOutput.
[[nodiscard]] TexturedMesh write_textured(const WrittenMesh& written, const ScanJob& job, const FrameArchive& archive,
                                          ScanSession& session);

}  // namespace scanknit
