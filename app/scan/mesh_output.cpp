#include "app/scan/mesh_output.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/config/quantity.h"
#include "app/scan/stage_timer.h"
#include "export/mesh/holes.h"
#include "export/mesh/write_mesh.h"
#include "export/picture/preview.h"

namespace scanknit {
namespace {

constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;

constexpr std::size_t kHolesInReport = 20;

/// `unit_m`: of the mesh's coordinates.
void describe_holes(const Mesh& mesh, double unit_m, RunReport& report) {
  RunReport::Holes& holes = report.holes.emplace();
  if (report.mesh->boundary_edges == 0) return;
  for (const Hole& hole : find_holes(mesh)) {
    ++holes.count;
    holes.total_length_m += unit_m * hole.length_m;
    if (holes.longest_m.size() < kHolesInReport) holes.longest_m.push_back(unit_m * hole.length_m);
  }
}

SurfaceFit measure_fit(const Mesh& mesh, const MeshFrame& frame, const FusionConfig& config, RunReport& report) {
  const FitBand band{config.truncation_voxels * config.voxel_size_m, config.truncation_sigmas, config.noise};
  SurfaceFit fit = fit_surface(mesh, frame.depths, band);
  report.fit = {fit.frames, fit.seen_share, fit.median_m, fit.p95_m, error_map_end_m(fit), coverage_map_end(fit)};
  return fit;
}

Result<void> write_picture(const char* kind, const ColourImage& picture, const std::filesystem::path& path,
                           RunReport& report) {
  report.files[kind] = path.string();
  return timed(report, "write", [&] { return write_png(picture, path); });
}

/// What the preview is for colour, these are for the depth frames.
Result<void> write_maps(const Mesh& mesh, const SurfaceFit& fit, const MeshFrame& frame, const Job& job,
                        RunReport& report) {
  const UpAxis up = job.config.output.world_up.value_or(frame.world_up);
  const auto error = timed(report, "export", [&] { return draw_error_map(mesh, fit, up, frame.T_world_scanner); });
  const auto coverage =
      timed(report, "export", [&] { return draw_coverage_map(mesh, fit, up, frame.T_world_scanner); });
  if (auto written = write_picture("error", error, *job.outputs.error, report); !written) return written;
  return write_picture("coverage", coverage, *job.outputs.coverage, report);
}

Result<void> write_pictures(const Mesh& mesh, const MeshFrame& frame, const Job& job, RunReport& report) {
  std::optional<SurfaceFit> fit;
  if (!frame.depths.empty() && mesh.normals.size() == mesh.positions_m.size()) {
    fit = timed(report, "export", [&] { return measure_fit(mesh, frame, job.config.fusion, report); });
  }
  if (!job.outputs.preview) return {};
  const UpAxis up = job.config.output.world_up.value_or(frame.world_up);
  const ColourImage picture = timed(report, "export", [&] { return render_preview(mesh, up, frame.T_world_scanner); });
  if (auto written = write_picture("preview", picture, *job.outputs.preview, report); !written) return written;
  return fit && job.outputs.error ? write_maps(mesh, *fit, frame, job, report) : Result<void>();
}

}  // namespace

void describe_volume(const TsdfVolume& volume, RunReport& report) {
  report.volume.active_voxels = volume.active_voxels();
  report.volume.blocks = volume.blocks();
  report.volume.memory_mib = static_cast<double>(volume.memory().bytes()) / kBytesPerMebibyte;
  report.volume.voxel_size_m = volume.config().voxel_size_m;
}

void describe_volume(const LoadedVolume& volume, RunReport& report) {
  const openvdb::FloatGrid& field = *volume.field;
  std::size_t bytes = field.memUsage();
  if (volume.weight) bytes += volume.weight->memUsage();
  if (volume.colour) bytes += volume.colour->memUsage();
  report.volume.active_voxels = field.activeVoxelCount();
  report.volume.blocks = field.tree().leafCount();
  report.volume.memory_mib = static_cast<double>(bytes) / kBytesPerMebibyte;
  report.volume.voxel_size_m = field.voxelSize().x();
  report.volume.format = "OpenVDB";
}

void describe_volume(const VolumeHeader& header, bool is_streamed, RunReport& report) {
  RunReport::Volume& volume = report.volume;
  const auto blocks = [](int samples) { return static_cast<std::size_t>((samples + 7) / 8); };
  volume.active_voxels = 1;
  volume.blocks = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto column = static_cast<Eigen::Index>(axis);
    volume.dims[axis] = header.dims[column];
    volume.spacing_m[axis] = header.T_file_index.linear().col(column).norm() * header.metres_per_unit;
    volume.active_voxels *= static_cast<std::size_t>(header.dims[column]);
    volume.blocks *= blocks(header.dims[column]);
  }
  volume.format = header.format;
  volume.voxel_size_m = *std::min_element(volume.spacing_m.begin(), volume.spacing_m.end());
  volume.is_streamed = is_streamed;
  volume.memory_mib = is_streamed ? 0 : static_cast<double>(volume.active_voxels * sizeof(float)) / kBytesPerMebibyte;
}

void describe_cases(const CaseCounts& counts, RunReport& report) {
  RunReport::Extract& extract = report.extract;
  extract.sub_cases.clear();
  for (const SubCase& sub_case : counts.sub_cases) extract.sub_cases.emplace_back(sub_case.name, sub_case.cells);
  constexpr int kConfigurations = 15;
  for (int i = 0; i < kConfigurations; ++i) {
    extract.cases[fmt::format("configuration_{:02}", i)] = counts.of_configuration(i);
  }
  extract.cases["ambiguous_faces_joined"] = counts.ambiguous_faces_joined;
  extract.cases["ambiguous_faces_separated"] = counts.ambiguous_faces_separated;
  extract.cases["tunnels"] = counts.tunnels;
  extract.cases["skipped_cells"] = counts.skipped_cells;
  extract.cases["components_removed"] = counts.components_removed;
}

Error empty_mesh_error(const Job& job) {
  const ExtractConfig& extract = job.config.extract;
  std::string message = "the mesh is empty: no observed cell meets the surface";
  if (extract.min_component_triangles > 0) {
    message += fmt::format("; pieces below {} triangles are removed (extract.min_component_triangles)",
                           extract.min_component_triangles);
  }
  if (extract.min_weight > 0) {
    message +=
        fmt::format("; voxels below weight {} are left out (extract.min_weight)", format_number(extract.min_weight));
  }
  if (extract.isovalue != 0) message += fmt::format("; extract.isovalue is {}", format_number(extract.isovalue));
  return {ErrorCode::kMesh, std::move(message), job.input.string()};
}

Result<void> write_surface(const Surface& surface, const MeshFrame& frame, const Job& job, RunReport& report) {
  const Mesh& mesh = surface.mesh;
  describe_cases(surface.cases, report);
  report.mesh = check_mesh(mesh);
  report.mesh->min_m *= static_cast<float>(frame.file_unit_m.value_or(1));
  report.mesh->max_m *= static_cast<float>(frame.file_unit_m.value_or(1));
  if (mesh.empty()) return empty_mesh_error(job);
  describe_holes(mesh, frame.file_unit_m.value_or(1), report);

  const ExportConfig& config = job.config.output;
  for (const std::filesystem::path& path : job.outputs.meshes) {
    const auto written =
        timed(report, "export", [&] { return write_mesh(mesh, path, config, frame.world_up, frame.file_unit_m); });
    if (!written) return written.error();
    report.files[path.extension().string().substr(1)] = path.string();
  }
  return write_pictures(mesh, frame, job, report);
}

void warn_of_holes(const ExtractConfig& config, Console& console) {
  if (config.decider != Decider::kLorensen) return;
  console.warn("extract.decider: lorensen leaves holes in the mesh; it is for teaching only (trilinear leaves none)");
}

}  // namespace scanknit
