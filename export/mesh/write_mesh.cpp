#include "export/mesh/write_mesh.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "core/files/lower_extension.h"
#include "export/glb/glb_writer.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/mesh_writers.h"
#include "export/placement_plan.h"
#include "export/texture/mesh_texture.h"
#include "export/tiles/write_tiles.h"

namespace scanknit {
namespace {

/// What every format needs.
Result<void> check_exportable(const Mesh& mesh, const Placement& placement) {
  const auto failure = [](std::string what) { return Error{ErrorCode::kMesh, std::move(what)}; };
  const std::size_t n = mesh.positions_m.size();
  if (mesh.empty() || n == 0) return failure("the mesh is empty");
  if (auto fits = check_counts(n, mesh.triangles.size()); !fits) return fits;
  if ((!mesh.normals.empty() && mesh.normals.size() != n) || (!mesh.colours.empty() && mesh.colours.size() != n)) {
    return failure("the mesh's normals or colours are not one a vertex");
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!placement.position(mesh.positions_m[i]).allFinite()) {
      return failure(fmt::format("the position of vertex {} is not finite", i));
    }
  }
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (!mesh.normals[i].allFinite()) return failure(fmt::format("the normal of vertex {} is not finite", i));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (*std::max_element(mesh.triangles[i].begin(), mesh.triangles[i].end()) >= n) {
      return failure(fmt::format("triangle {} names a vertex beyond the {} there are", i, n));
    }
  }
  return {};
}

Result<void> check_uncertainty(const Mesh& mesh, std::span<const float> uncertainty_m) {
  if (uncertainty_m.empty() || uncertainty_m.size() == mesh.positions_m.size()) return {};
  return Error{ErrorCode::kMesh, "the mesh's uncertainties are not one a vertex"};
}

Result<void> check_texture(const Mesh& mesh, const MeshTexture* texture) {
  if (texture == nullptr) return {};
  const auto is_finite = [](const Eigen::Vector2f& coordinate) { return coordinate.allFinite(); };
  const bool fits = texture->coordinates.size() == mesh.positions_m.size() && mesh.colours.empty() &&
                    !texture->image.empty() &&
                    std::all_of(texture->coordinates.begin(), texture->coordinates.end(), is_finite);
  return fits ? Result<void>() : Error{ErrorCode::kMesh, "the texture does not fit the mesh"};
}

Result<void> write_as(const PlacementPlan& plan, const Mesh& mesh, const ExportConfig& config,
                      const MeshTexture* texture, std::span<const float> uncertainty_m, AtomicFile& file) {
  switch (plan.format) {
    case MeshFormat::kGlb: return write_glb({mesh, plan.placement, texture}, config, file);
    case MeshFormat::kPly: return write_ply(mesh, plan.placement, uncertainty_m, file);
    case MeshFormat::kObj: return write_obj(mesh, plan.placement, file);
    case MeshFormat::kStl: return write_stl(mesh, plan.placement, file);
    case MeshFormat::kThreeMf: return write_3mf(mesh, plan.placement, file);
    case MeshFormat::kTiles: break;  // no single file
    case MeshFormat::kStep: break;   // read only
  }
  return Error{ErrorCode::kInternal, "a format without a writer"};
}

}  // namespace

std::optional<MeshFormat> mesh_format(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".glb") return MeshFormat::kGlb;
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".stl") return MeshFormat::kStl;
  if (extension == ".3mf") return MeshFormat::kThreeMf;
  if (extension == ".tiles") return MeshFormat::kTiles;
  if (extension == ".step" || extension == ".stp") return MeshFormat::kStep;
  return std::nullopt;
}

bool is_glb_path(const std::filesystem::path& path) {
  return mesh_format(path) == MeshFormat::kGlb;
}

bool is_tiles_path(const std::filesystem::path& path) {
  return mesh_format(path) == MeshFormat::kTiles;
}

bool is_mesh_path(const std::filesystem::path& path) {
  return mesh_format(path).has_value();
}

Result<WrittenFile> write_mesh(const Mesh& mesh, const std::filesystem::path& path, const ExportConfig& config,
                               UpAxis world_up, std::optional<double> file_unit_m, const MeshTexture* texture,
                               std::span<const float> uncertainty_m) {
  const std::optional<MeshFormat> format = mesh_format(path);
  if (!format || *format == MeshFormat::kStep) {
    return Error{ErrorCode::kOutput,
                 fmt::format("unknown mesh extension '{}'; known are {}", path.extension().string(), kMeshExtensions),
                 path.string()};
  }
  const PlacementPlan plan = plan_placement(*format, config, world_up, file_unit_m);
  if (auto checked = check_exportable(mesh, plan.placement); !checked) return located(checked.error(), path);
  if (auto checked = check_texture(mesh, texture); !checked) return located(checked.error(), path);
  if (auto checked = check_uncertainty(mesh, uncertainty_m); !checked) return located(checked.error(), path);
  if (*format == MeshFormat::kTiles) return write_tiles(mesh, plan, config, path);
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = write_as(plan, mesh, config, texture, uncertainty_m, *file); !written)
    return located(written.error(), path);
  if (auto committed = file->commit(); !committed) return committed.error();
  return written_file(path, plan);
}

}  // namespace scanknit
