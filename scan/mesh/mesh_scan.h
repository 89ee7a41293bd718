// The mesh of a reconstruction, written to all files of a job.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/axes.h"
#include "core/result.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/write_texture.h"
#include "scan/reconstruction.h"
#include "scan/scan_job.h"
#include "scan/scan_result.h"
#include "scan/scan_session.h"

namespace scanknit {

/// What to do when no part of the mesh is within the crop box.
enum class EmptyCrop {
  kRefused,  ///< an error: the user can still change the box
  kIgnored,  ///< the whole mesh is written, with a warning: a scan is never lost
};

struct MeshRequest {
  const ScanJob& job;
  UpAxis world_up;
  const CropBox& crop;
  EmptyCrop empty_crop = EmptyCrop::kIgnored;
  std::stop_token stop = {};  ///< see FinishRequest
  /// See FinishRequest. Not called if there is a crop box: the whole volume may be needed after it.
  std::function<void()> on_volume_read = {};
};

/// The mesh of a reconstruction. After an error, what was made before it.
struct MeshedScan {
  Result<void> outcome;
  MeshResult result;
  WrittenMesh written;
};

/// The frames of a scan that was fused.
struct ScannedFrames {
  const Trajectory& trajectory;     ///< not empty
  std::vector<PosedDepth> samples;  ///< some of them, evenly spread: Reconstruction::depth_samples()
};

/// Writes a surface that was extracted and finished. `outcome`: that of the surface; kMesh when it is empty; kOutput.
[[nodiscard]] MeshedScan mesh_finished(FinishedSurface finished, ScannedFrames frames, const MeshRequest& request,
                                       ScanSession& session);

/// The standard deviation of a view of weight 1 in a volume that depth frames were fused into, metres; `samples`: some
/// of them. Nothing unless export.uncertainty asks for it.
[[nodiscard]] std::optional<double> view_sigma_m(const TsdfVolume& volume, std::span<const PosedDepth> samples,
                                                 const ScanConfig& config);

/// `outcome`: kTooLittle before the first frame; kMesh when there is no surface; kOutput.
[[nodiscard]] MeshedScan mesh_scan(const Reconstruction& scan, const MeshRequest& request, ScanSession& session);

}  // namespace scanknit
