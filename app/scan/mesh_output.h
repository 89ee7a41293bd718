// From a surface to files, and what the report says of both.
#pragma once

#include <optional>
#include <vector>

#include "app/scan/pipeline.h"
#include "core/axes.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/picture/surface_fit.h"
#include "export/report/report.h"
#include "extract/extract_surface.h"
#include "extract/volume/volume_header.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

void describe_volume(const TsdfVolume& volume, RunReport& report);
void describe_volume(const LoadedVolume& volume, RunReport& report);
void describe_volume(const VolumeHeader& header, bool is_streamed, RunReport& report);
void describe_cases(const CaseCounts& cases, RunReport& report);

/// kMesh, with what most often is the reason.
[[nodiscard]] Error empty_mesh_error(const Job& job);

/// What a mesh's coordinates mean.
struct MeshFrame {
  UpAxis world_up;
  std::optional<Pose> T_world_scanner;  ///< of a frame in the middle of the scan: from where a person would look
  std::optional<double> file_unit_m;    ///< metres per unit of a volume file's own coordinates; nothing: a scan, metres
  std::vector<PosedDepth> depths = {};  ///< some of the frames that it was made of
};

/// Tells the report of the surface; writes every mesh file, then the pictures. kMesh where the surface is empty.
[[nodiscard]] Result<void> write_surface(const Surface& surface, const MeshFrame& frame, const Job& job,
                                         RunReport& report);

/// A warning where the decider's meshes have holes by design.
void warn_of_holes(const ExtractConfig& config, Console& console);

}  // namespace scanknit
