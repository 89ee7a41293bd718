#include "scan/bricks/join_parts.h"

#include <fmt/format.h>

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/files/quantity.h"
#include "core/system/freed_memory.h"
#include "export/trajectory.h"
#include "finish/coarse_volume.h"
#include "fusion/volume/block_size.h"
#include "scan/bricks/layered_bricks.h"
#include "scan/checks/memory_share.h"
#include "scan/mesh/memory_left.h"
#include "scan/mesh/mesh_scan.h"
#include "scan/mesh/vertex_uncertainty.h"
#include "scan/mesh/view_spread.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {
namespace {

/// Reads the bricks again, a layer at a time with its neighbours, which have the other corners of its last cells and
/// the rest of patches.
Result<void> estimate_uncertainty(const ScanConfig& config, LayeredBricks& layers, std::span<const PosedDepth> samples,
                                  FinishedSurface& finished) {
  if (!config.output.uncertainty || !finished.outcome) return {};
  const Mesh& mesh = finished.surface.mesh;
  VertexEvidence evidence(mesh.positions_m.size());
  ViewSpread spread(samples, config.fusion.noise);
  for (const BlockLayer& layer : layers.layers()) {
    const auto view = layers.read(layer.x - kBlockEdgeVoxels, layer.x + 3 * kBlockEdgeVoxels);
    if (!view) return view.error();
    const int end_x = layer.x + kBlockEdgeVoxels;
    add_evidence(mesh, finished.T_mesh_world().inverse(), *view, evidence, layer.x, end_x);
    spread.add(*view, layer.x, end_x);
  }
  finished.uncertainty_m = uncertainties_m(evidence, {spread.view_sigma_m(), config.fusion.voxel_size_m});
  return {};
}

/// Reads the volume with voxels of twice the size.
Result<CoarseVolume> read_coarse(LayeredBricks& layers, double min_weight) {
  std::optional<CoarseVolume> coarse;
  for (const BlockLayer& layer : layers.layers()) {
    const auto view = layers.read(layer.x, layer.x + kBlockEdgeVoxels);
    if (!view) return view.error();
    if (!coarse) coarse.emplace(*view, 2);
    coarse->add(*view, min_weight);
  }
  if (!coarse) return Error{ErrorCode::kMesh, "the mesh is empty: no voxel was observed"};
  return *std::move(coarse);
}

/// The finished mesh of voxels of twice the size: for what needs the whole volume, or for a mesh that would be too
/// large.
Result<FinishedSurface> finish_coarse(FinishRequest request, const std::string& reason, LayeredBricks& layers,
                                      ScanSession& session) {
  auto read = session.timed("extract", [&] { return read_coarse(layers, request.config.extract.min_weight); });
  if (!read) return read.error();
  const ScanWarning warning = session.warn_of_mesh(WarningCode::kFinishStep, "",
                                                   fmt::format("{}. The mesh is made of voxels of {} instead", reason,
                                                               format_length(2 * request.config.fusion.voxel_size_m)));
  std::optional<CoarseVolume> coarse = *std::move(read);
  request.coarseness = 2;
  request.on_volume_read = [&] { coarse.reset(); };
  FinishedSurface finished = finished_surface(coarse->finish(), request, session);
  finished.warnings.insert(finished.warnings.begin(), warning);
  return finished;
}

Result<FinishedSurface> extract_and_finish(const FinishRequest& request, LayeredBricks& layers, ScanSession& session) {
  constexpr std::size_t kBytesPerBlock = 8192;  // with what extraction keeps of it
  const ScanConfig& config = request.config;
  if (config.finish.watertight != Watertight::kOff) {
    return finish_coarse(request,
                         "the volume needs more than its part of fusion.memory_budget, and is too large "
                         "to be closed (finish.watertight)",
                         layers, session);
  }
  // Beside the mesh, which grows meanwhile.
  const std::size_t layers_mib = volume_budget_mib(config.fusion.memory_budget_mib) / 4;
  auto surface = session.timed(
      "extract", [&] { return extract_surface(layers, config.extract, (layers_mib << 20) / kBytesPerBlock); });
  if (!surface) return surface.error();
  if (const auto reason = too_large_to_simplify(surface->mesh, config, 0)) {
    surface = Surface();
    return finish_coarse(request, *reason, layers, session);
  }
  layers.let_go();
  return_freed_memory();
  return finished_mesh(*std::move(surface), request, session);
}

}  // namespace

Result<void> join_parts(const ScanJob& job, UpAxis world_up, const BrickVolume& bricks, const DepthSamples& samples,
                        const FrameArchive& archive, ScanSession& session, ScanResult& result) {
  return_freed_memory();  // that of frames and parts
  LayeredBricks layers(bricks);
  const CropBox no_crop;
  const MeshRequest request{job, world_up, no_crop, EmptyCrop::kIgnored, session.stop()};
  ScannedFrames frames{result.trajectory, samples.posed(result.trajectory)};
  auto extracted = extract_and_finish({job.config, world_up, 1, session.stop(), frames.samples}, layers, session);
  if (!extracted) return extracted.error();
  FinishedSurface finished = *std::move(extracted);
  result.volume = layers.described();
  result.volume.voxel_size_m = job.config.fusion.voxel_size_m;
  const auto estimated =
      session.timed("finish", [&] { return estimate_uncertainty(job.config, layers, frames.samples, finished); });
  if (!estimated) return estimated;
  layers.let_go();
  return_freed_memory();
  MeshedScan meshed = mesh_finished(std::move(finished), std::move(frames), request, session);
  result.mesh = std::move(meshed.result);
  for (const auto& [kind, path] : result.mesh.files) result.files[kind] = path;
  if (!meshed.outcome) return meshed.outcome;
  TexturedMesh textured = write_textured(meshed.written, job, archive, session);
  result.texture = std::move(textured.texture);
  return textured.outcome;
}

Result<void> write_trajectory(const ScanJob& job, ScanSession& session, ScanResult& result) {
  if (!job.files.trajectory) return {};
  result.files["trajectory"] = job.files.trajectory->string();
  const std::string text = trajectory_text(*job.files.trajectory, stamped_poses(result.trajectory));
  return session.timed("write", [&] { return write_file_atomically(*job.files.trajectory, text); });
}

bool needs_samples(const ScanJob& job) {
  return job.measures_fit || job.config.finish.drops_crumbs || job.config.output.uncertainty;
}

}  // namespace scanknit
