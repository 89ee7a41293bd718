#include "scan/bricks/join_parts.h"

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/files/atomic_file.h"
#include "core/system/freed_memory.h"
#include "export/trajectory.h"
#include "fusion/volume/block_size.h"
#include "scan/bricks/layered_bricks.h"
#include "scan/mesh/mesh_scan.h"
#include "scan/mesh/vertex_uncertainty.h"
#include "scan/mesh/view_spread.h"
#include "scan/mesh/write_texture.h"

namespace scanknit {
namespace {

/// Reads the bricks again, a layer at a time with its neighbours, which have the other corners of its last cells and
/// the rest of patches.
Result<void> estimate_uncertainty(const ScanConfig& config, std::optional<LayeredBricks>& layers,
                                  std::span<const PosedDepth> samples, FinishedSurface& finished) {
  if (!config.output.uncertainty || !layers || !finished.outcome) return {};
  const Mesh& mesh = finished.surface.mesh;
  VertexEvidence evidence(mesh.positions_m.size());
  ViewSpread spread(samples, config.fusion.noise);
  for (const BlockLayer& layer : layers->layers()) {
    const auto view = layers->read(layer.x - kBlockEdgeVoxels, layer.x + 3 * kBlockEdgeVoxels);
    if (!view) return view.error();
    const int end_x = layer.x + kBlockEdgeVoxels;
    add_evidence(mesh, finished.T_mesh_world().inverse(), *view, evidence, layer.x, end_x);
    spread.add(*view, layer.x, end_x);
  }
  finished.uncertainty_m = uncertainties_m(evidence, {spread.view_sigma_m(), config.fusion.voxel_size_m});
  return {};
}

}  // namespace

Result<void> join_parts(const ScanJob& job, UpAxis world_up, const BrickVolume& bricks, const DepthSamples& samples,
                        const FrameArchive& archive, ScanSession& session, ScanResult& result) {
  constexpr std::size_t kBytesPerBlock = 8192;  // with what extraction keeps of it
  return_freed_memory();                        // that of frames and parts
  const std::size_t blocks_at_once = (job.config.fusion.memory_budget_mib << 20) / kBytesPerBlock;
  std::optional<LayeredBricks> layers(bricks);
  auto surface = session.timed("extract", [&] { return extract_surface(*layers, job.config.extract, blocks_at_once); });
  if (!surface) return surface.error();
  result.volume = layers->described();
  result.volume.voxel_size_m = job.config.fusion.voxel_size_m;
  if (!job.config.output.uncertainty) layers.reset();  // its last layers
  return_freed_memory();
  const CropBox no_crop;
  const MeshRequest request{job, world_up, no_crop, EmptyCrop::kIgnored, session.stop()};
  ScannedFrames frames{result.trajectory, samples.posed(result.trajectory)};
  FinishedSurface finished =
      finished_mesh(*std::move(surface), {job.config, world_up, 1, session.stop(), frames.samples}, session);
  const auto estimated =
      session.timed("finish", [&] { return estimate_uncertainty(job.config, layers, frames.samples, finished); });
  if (!estimated) return estimated;
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
