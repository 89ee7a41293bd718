#include "app/mesh_output.h"

#include <fmt/format.h>

#include "app/quantity.h"
#include "app/stage_timer.h"
#include "export/preview.h"
#include "export/write_mesh.h"

namespace scanknit {
namespace {

constexpr double kBytesPerMebibyte = 1024.0 * 1024.0;

}  // namespace

void describe_volume(const TsdfVolume& volume, RunReport& report) {
  report.volume.active_voxels = volume.active_voxels();
  report.volume.blocks = volume.blocks();
  report.volume.memory_mib = volume.memory_mib();
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
}

void describe_surface(const Surface& surface, RunReport& report) {
  const CaseCounts& cases = surface.cases;
  for (std::size_t i = 0; i < cases.configuration.size(); ++i) {
    report.extract_cases[fmt::format("configuration_{:02}", i)] = cases.configuration[i];
  }
  report.extract_cases["ambiguous_faces_joined"] = cases.ambiguous_faces_joined;
  report.extract_cases["ambiguous_faces_separated"] = cases.ambiguous_faces_separated;
  report.extract_cases["skipped_cells"] = cases.skipped_cells;
  report.extract_cases["components_removed"] = cases.components_removed;
  report.mesh = check_mesh(surface.mesh);
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

Result<void> write_outputs(const Mesh& mesh, const Viewpoint& viewpoint, const Job& job, RunReport& report) {
  const ExportConfig& config = job.config.output;
  for (const std::filesystem::path& path : job.outputs.meshes) {
    const auto written = timed(report, "export", [&] { return write_mesh(mesh, path, config, viewpoint.world_up); });
    if (!written) return written.error();
    report.files[path.extension().string().substr(1)] = path.string();
  }
  if (!job.outputs.preview) return {};
  const ColourImage picture = timed(report, "export", [&] {
    return render_preview(mesh, config.world_up.value_or(viewpoint.world_up), viewpoint.T_world_scanner);
  });
  report.files["preview"] = job.outputs.preview->string();
  return timed(report, "write", [&] { return write_png(picture, *job.outputs.preview); });
}

}  // namespace scanknit
