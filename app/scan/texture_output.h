// A baked texture in the GLB: the colour frames of the scan are read once more.
#pragma once

#include "app/scan/fuse_again.h"
#include "app/scan/pipeline.h"
#include "app/scan/second_look.h"
#include "core/axes.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/report/report.h"

namespace scanknit {

/// A mesh that has been written, and where the frames stood that it was made of. Empty unless a texture is wanted.
struct WrittenMesh {
  Mesh mesh;
  UpAxis world_up = UpAxis::kMinusY;
  PosesBySequence T_mesh_camera;
};

/// Writes the job's GLB files anew, with a texture in the place of the vertices' colours, when the job asks for it.
/// When there can be none, they stay as they are; the reason is in report.texture and among the warnings: a scan is
/// never lost. Errors: kOutput.
[[nodiscard]] Result<void> write_textured(const WrittenMesh& written, const Job& job, const SecondLook& again,
                                          Console& console, RunReport& report);

/// kConfig if a texture is wanted of a `command` that has no frames to take it from.
[[nodiscard]] Result<void> refuse_texture(const Config& config, const char* command);

}  // namespace scanknit
