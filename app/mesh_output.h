// From a surface to files, and what the report says of both.
#pragma once

#include "app/pipeline.h"
#include "core/axes.h"
#include "core/result.h"
#include "export/report.h"
#include "extract/extract_surface.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {

void describe_volume(const TsdfVolume& volume, RunReport& report);
void describe_volume(const LoadedVolume& volume, RunReport& report);
void describe_surface(const Surface& surface, RunReport& report);

/// kMesh, with what most often is the reason.
[[nodiscard]] Error empty_mesh_error(const Job& job);

/// Writes every mesh file, then the preview.
[[nodiscard]] Result<void> write_outputs(const Mesh& mesh, UpAxis world_up, const Job& job, RunReport& report);

}  // namespace scanknit
