#include "scan/mesh/mesh_scan.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/system/beside.h"
#include "core/system/freed_memory.h"
#include "export/measure/doubled_surface.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/memory_left.h"
#include "scan/mesh/view_spread.h"
#include "scan/mesh/write_surface.h"

namespace scanknit {
namespace {

/// The samples within the box.
openvdb::CoordBBox index_box(const Eigen::AlignedBox3d& box, double voxel_size_m) {
  const auto index = [&](double metres, double (*round)(double)) {
    constexpr double kFarthest = 1e9;  // the box may reach far beyond any volume
    return static_cast<int>(std::clamp(round(metres / voxel_size_m), -kFarthest, kFarthest));
  };
  const auto first = [&](int axis) { return index(box.min()[axis], std::ceil); };
  const auto last = [&](int axis) { return index(box.max()[axis], std::floor); };
  return {{first(0), first(1), first(2)}, {last(0), last(1), last(2)}};
}

FieldView field_view(const TsdfVolume& volume, const CropBox& crop) {
  FieldView view = volume.field_view();
  if (crop) view.region = index_box(*crop, volume.config().voxel_size_m);
  return view;
}

FinishedSurface surface_of(const Reconstruction& scan, std::span<const PosedDepth> frames, const MeshRequest& request,
                           ScanSession& session) {
  FinishRequest finish{request.job.config, request.world_up, 1,
                       request.stop,       frames,           view_sigma_m(scan.volume(), frames, request.job.config)};
  if (!request.crop) finish.on_volume_read = request.on_volume_read;
  const auto extract = [&](const CropBox& crop) {
    return finished_surface(field_view(scan.volume(), crop), finish, session);
  };
  FinishedSurface cropped = extract(request.crop);
  if (!cropped.outcome || !request.crop || !cropped.surface.mesh.empty()) return cropped;
  if (request.empty_crop == EmptyCrop::kRefused) {
    cropped.outcome = Error{ErrorCode::kMesh, "nothing lies within the crop box: clear it, or make it larger"};
    return cropped;
  }
  FinishedSurface whole = extract(std::nullopt);
  if (!whole.outcome || whole.surface.mesh.empty()) return whole;
  whole.warnings.push_back(session.warn_of_mesh(WarningCode::kCropBoxIgnored, "",
                                                "nothing lies within the crop box: the whole mesh was written"));
  return whole;
}

/// Nothing for a simplified mesh, whose vertices are too far apart.
std::optional<DoubledResult> doubled_surface(const Mesh& mesh, const ScanConfig& config) {
  if (mesh.empty() || config.finish.triangles || config.finish.simplify_error_m) return std::nullopt;
  const DoubledSurface doubled = find_doubled_surface(mesh, config.fusion.voxel_size_m);
  return DoubledResult{doubled.area_m2, doubled.share};
}

MeshFrame frame_of(ScannedFrames frames, const MeshRequest& request, const Pose& T_mesh_world) {
  // The preview's viewpoint: where the scanner was half way through the scan.
  const Pose& T_world_scanner = frames.trajectory[frames.trajectory.size() / 2].T_world_camera;
  MeshFrame frame{request.world_up, T_mesh_world * T_world_scanner, std::nullopt};
  if (request.job.measures_fit) frame.depths = std::move(frames.samples);
  for (PosedDepth& depth : frame.depths) depth.T_world_camera = T_mesh_world * depth.T_world_camera;
  return frame;
}

/// What a texture is baked from; empty if the job asks for none.
WrittenMesh written_mesh(FinishedSurface finished, const Trajectory& trajectory, const MeshRequest& request) {
  WrittenMesh written{{}, request.world_up, {}};
  if (request.job.config.output.texture == TextureFormat::kOff) return written;
  const Pose T_mesh_world = finished.T_mesh_world();
  written.mesh = std::move(finished.surface.mesh);
  for (const PosedFrame& posed : trajectory) {
    written.T_mesh_camera[posed.sequence] = T_mesh_world * posed.T_world_camera;
  }
  return written;
}

}  // namespace

MeshedScan mesh_finished(FinishedSurface finished, ScannedFrames frames, const MeshRequest& request,
                         ScanSession& session) {
  MeshedScan meshed;
  const ScanConfig& config = request.job.config;
  meshed.result.isovalue = config.extract.isovalue;
  add_to(meshed.result, finished);
  meshed.outcome = finished.outcome;
  if (!finished.outcome) return meshed;
  const Mesh& mesh = finished.surface.mesh;
  const Trajectory& trajectory = frames.trajectory;
  auto doubled = beside([&] { return doubled_surface(mesh, config); }, has_room_to_check_beside(mesh, config));
  MeshFrame frame = frame_of(std::move(frames), request, finished.T_mesh_world());
  frame.uncertainty_m = std::move(finished.uncertainty_m);
  WrittenSurface written = write_surface(mesh, frame, request.job, session);
  return_freed_memory();
  meshed.result.doubled = session.timed("export", [&] { return doubled.get(); });
  meshed.outcome = written.outcome;
  add_to(meshed.result, std::move(written));
  if (meshed.outcome) meshed.written = written_mesh(std::move(finished), trajectory, request);
  return meshed;
}

std::optional<double> view_sigma_m(const TsdfVolume& volume, std::span<const PosedDepth> samples,
                                   const ScanConfig& config) {
  if (!config.output.uncertainty) return std::nullopt;
  ViewSpread spread(samples, config.fusion.noise);
  spread.add(volume.field_view());
  return spread.view_sigma_m();
}

MeshedScan mesh_scan(const Reconstruction& scan, const MeshRequest& request, ScanSession& session) {
  if (scan.trajectory().empty()) {
    MeshedScan nothing;
    nothing.outcome = Error{ErrorCode::kTooLittle, "nothing has been fused yet"};
    return nothing;
  }
  ScannedFrames frames{scan.trajectory(), scan.depth_samples()};
  FinishedSurface finished = surface_of(scan, frames.samples, request, session);
  return mesh_finished(std::move(finished), std::move(frames), request, session);
}

}  // namespace scanknit
