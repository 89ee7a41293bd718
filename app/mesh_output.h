// From a surface to files, and what the report says of both.
#pragma once

#include <optional>

#include "app/pipeline.h"
#include "core/axes.h"
#include "core/pose.h"
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

/// From where a person would look at the mesh.
struct Viewpoint {
  UpAxis world_up;
  std::optional<Pose> T_world_scanner;  ///< of a frame in the middle of the scan
};

/// Writes every mesh file, then the preview.
[[nodiscard]] Result<void> write_outputs(const Mesh& mesh, const Viewpoint& viewpoint, const Job& job,
                                         RunReport& report);

}  // namespace scanknit
