#include "app/measure/measured_mesh.h"

#include <fmt/format.h>

#include "core/files/located.h"
#include "core/mesh/unused_vertices.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/read_mesh.h"
#include "export/spill/stitch_borders.h"
#include "measure/area_points.h"

namespace scanknit {

MeshUnit usual_unit(const std::filesystem::path& file) {
  const auto format = mesh_format(file);
  const bool is_millimetre = format == MeshFormat::kStl || format == MeshFormat::kStep;
  return is_millimetre ? MeshUnit::kMillimetre : MeshUnit::kMetre;
}

Result<MeasuredMesh> read_measured_mesh(const std::filesystem::path& file, std::optional<MeshUnit> unit) {
  MeshNotes notes;
  auto mesh = read_mesh(file, {}, &notes);
  if (!mesh) return mesh.error();
  if (notes.has_texture_coordinates) stitch_seams(*mesh);
  drop_unused_vertices(*mesh);
  MeasuredMesh measured{.mesh = *std::move(mesh),
                        .unit = unit.value_or(usual_unit(file)),
                        .is_unit_given = unit.has_value(),
                        .is_unit_stated = mesh_format(file) == MeshFormat::kStep,
                        .warnings = {}};
  for (const std::string& warning : notes.warnings) {
    measured.warnings.push_back(fmt::format("{}: {}", file.string(), warning));
  }
  to_metres(measured.mesh, measured.unit);
  if (const auto usable = check_measurable(measured.mesh); !usable) return located(usable.error(), file);
  return measured;
}

}  // namespace scanknit
