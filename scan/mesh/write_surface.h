// Writes a surface to mesh files and pictures.
#pragma once

#include <optional>
#include <vector>

#include "core/axes.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/picture/surface_fit.h"
#include "scan/mesh/finish_surface.h"
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
  std::vector<float> uncertainty_m = {};  ///< FinishedSurface::uncertainty_m
};

/// The files of a surface and what was measured of it. After an error, what was made before it.
struct WrittenSurface {
  Result<void> outcome;
  MeshCheck check;
  std::optional<HolesResult> holes;  ///< nothing for an empty mesh
  std::optional<FitResult> fit;      ///< nothing without depth frames
  FilesByKind files;
};

/// Checks the surface and writes the job's mesh files, then its pictures. `outcome`: kMesh when the surface is empty;
/// kOutput.
[[nodiscard]] WrittenSurface write_surface(const Mesh& mesh, const MeshFrame& frame, const ScanJob& job,
                                           ScanSession& session);

/// Adds to the result of a mesh what finishing it and writing it made.
void add_to(MeshResult& result, const FinishedSurface& finished);
void add_to(MeshResult& result, WrittenSurface written);

}  // namespace scanknit
