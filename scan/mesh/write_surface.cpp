#include "scan/mesh/write_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/files/quantity.h"
#include "core/system/beside.h"
#include "core/system/freed_memory.h"
#include "export/measure/holes.h"
#include "export/mesh/write_mesh.h"
#include "export/picture/preview.h"
#include "export/picture/uncertainty_map.h"
#include "scan/mesh/fit_band.h"
#include "scan/mesh/memory_left.h"

namespace scanknit {
namespace {

constexpr std::size_t kHolesInResult = 20;

/// `unit_m`: metres per unit of the mesh's coordinates.
HolesResult describe_holes(const Mesh& mesh, const MeshCheck& check, double unit_m) {
  HolesResult holes;
  if (check.boundary_edges == 0) return holes;
  for (const Hole& hole : find_holes(mesh)) {
    ++holes.count;
    holes.total_length_m += unit_m * hole.length_m;
    if (holes.longest_m.size() < kHolesInResult) holes.longest_m.push_back(unit_m * hole.length_m);
  }
  return holes;
}

class SurfaceWriter {
 public:
  SurfaceWriter(const Mesh& mesh, const MeshFrame& frame, const ScanJob& job, ScanSession& session)
      : mesh_(mesh),
        frame_(frame),
        job_(job),
        session_(session),
        up_(job.config.output.world_up.value_or(frame.world_up)) {}

  /// To be called once.
  [[nodiscard]] WrittenSurface write() {
    written_.outcome = check_and_write();
    return std::move(written_);
  }

 private:
  /// The mesh is checked while its files are written, which do not depend on what is found.
  [[nodiscard]] Result<void> check_and_write() {
    if (mesh_.empty()) {
      check();
      return empty_mesh_error(job_);
    }
    auto checked = beside([this] { check(); }, has_room_to_check_beside(mesh_, job_.config));
    auto written = write_meshes();
    if (written) written = write_pictures();
    session_.timed("export", [&] { checked.get(); });
    return written;
  }

  void check() {
    const double unit_m = frame_.file_unit_m.value_or(1);
    written_.check = check_mesh(mesh_);
    written_.check.min_m *= static_cast<float>(unit_m);
    written_.check.max_m *= static_cast<float>(unit_m);
    if (!mesh_.empty()) written_.holes = describe_holes(mesh_, written_.check, unit_m);
  }

  [[nodiscard]] Result<void> write_meshes() {
    for (const std::filesystem::path& path : job_.files.meshes) {
      const auto written = session_.timed("export", [&] {
        return write_mesh(mesh_, path, job_.config.output, frame_.world_up, frame_.file_unit_m, nullptr,
                          frame_.uncertainty_m);
      });
      if (!written) return written.error();
      written_.files[path.extension().string().substr(1)] = path.string();
    }
    return {};
  }

  [[nodiscard]] Result<void> write_pictures() {
    std::optional<SurfaceFit> fit;
    if (!frame_.depths.empty() && mesh_.normals.size() == mesh_.positions_m.size()) {
      fit = session_.timed("export", [&] { return measure_fit(); });
    }
    if (auto written = write_uncertainty(); !written) return written;
    if (!job_.files.preview) return {};
    const ColourImage picture =
        session_.timed("export", [&] { return render_preview(mesh_, up_, frame_.T_world_scanner); });
    if (auto written = write_picture("preview", picture, *job_.files.preview); !written) return written;
    return fit && job_.files.error ? write_maps(*fit) : Result<void>();
  }

  [[nodiscard]] Result<void> write_uncertainty() {
    if (!job_.config.output.uncertainty) return {};
    if (frame_.uncertainty_m.empty()) {
      session_.warn(
          WarningCode::kNoEffect,
          "export.uncertainty has no effect because the volume's weights do not come from a depth sensor's noise");
      return {};
    }
    const auto path = uncertainty_picture(job_);
    if (!path) return {};
    const auto picture = session_.timed(
        "export", [&] { return draw_uncertainty_map(mesh_, frame_.uncertainty_m, up_, frame_.T_world_scanner); });
    return write_picture("uncertainty", picture, *path);
  }

  [[nodiscard]] SurfaceFit measure_fit() {
    SurfaceFit fit = fit_surface(mesh_, frame_.depths, fit_band_of(job_.config.fusion));
    return_freed_memory();
    written_.fit = {fit.frames, fit.seen_share, fit.median_m, fit.p95_m, error_map_end_m(fit), coverage_map_end(fit)};
    return fit;
  }

  [[nodiscard]] Result<void> write_picture(const char* kind, const ColourImage& picture,
                                           const std::filesystem::path& path) {
    written_.files[kind] = path.string();
    return session_.timed("write", [&] { return write_png(picture, path); });
  }

  /// Writes error.png and coverage.png: views like the preview, coloured by how well the mesh fits the depth frames.
  [[nodiscard]] Result<void> write_maps(const SurfaceFit& fit) {
    const auto error =
        session_.timed("export", [&] { return draw_error_map(mesh_, fit, up_, frame_.T_world_scanner); });
    const auto coverage =
        session_.timed("export", [&] { return draw_coverage_map(mesh_, fit, up_, frame_.T_world_scanner); });
    if (auto written = write_picture("error", error, *job_.files.error); !written) return written;
    return write_picture("coverage", coverage, *job_.files.coverage);
  }

  const Mesh& mesh_;
  const MeshFrame& frame_;
  const ScanJob& job_;
  ScanSession& session_;
  UpAxis up_;
  WrittenSurface written_;
};

}  // namespace

Error empty_mesh_error(const ScanJob& job) {
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

WrittenSurface write_surface(const Mesh& mesh, const MeshFrame& frame, const ScanJob& job, ScanSession& session) {
  return SurfaceWriter(mesh, frame, job, session).write();
}

void add_to(MeshResult& result, const FinishedSurface& finished) {
  result.finish = finished.steps;
  result.warnings = finished.warnings;
  if (finished.outcome) result.cases = finished.surface.cases;
}

void add_to(MeshResult& result, WrittenSurface written) {
  result.check = written.check;
  result.holes = std::move(written.holes);
  result.fit = written.fit;
  result.files = std::move(written.files);
}

}  // namespace scanknit
