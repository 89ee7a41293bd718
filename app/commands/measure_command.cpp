#include <fmt/format.h>

#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/measure/mesh_measures.h"
#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "core/mesh/mesh_area.h"
#include "measure/section/section_drawing.h"

namespace scanknit {
namespace {

Eigen::Vector3d in_metres(const GivenPoint& point, MeshUnit unit) {
  return {point[0].metres(unit), point[1].metres(unit), point[2].metres(unit)};
}

SectionPlane plane_of(const GivenPlane& given, MeshUnit unit) {
  const double offset_m = given.point ? given.normal.dot(in_metres(*given.point, unit)) : given.offset.metres(unit);
  return section_plane(given.normal, offset_m);
}

void measure_solid(const Mesh& mesh, MeshMeasures& measures) {
  for (const Eigen::Vector3f& p : mesh.positions_m) measures.bounds_m.extend(p.cast<double>());
  measures.vertices = mesh.positions_m.size();
  measures.triangles = mesh.triangles.size();
  measures.area_m2 = area_m2(mesh);
  measures.box = find_oriented_box(mesh);
  measures.volume = measure_volume(mesh);
  measures.holes = find_holes(mesh);
  if (measures.volume.tangled_edges > 0) return;
  measures.thickness = measure_thickness(mesh, TriangleBvh(mesh), measures.volume.is_inside_out, measures.thin_m);
}

Result<void> measure_places(const Mesh& mesh, const MeasureArguments& arguments, MeshMeasures& measures) {
  for (const GivenPlane& given : arguments.sections) {
    measures.sections.push_back(cut_mesh(mesh, plane_of(given, measures.unit)));
  }
  const double radius_m = arguments.radius ? arguments.radius->metres(measures.unit) : 0;
  if (arguments.plane_at) {
    const auto plane = fit_plane(mesh, in_metres(*arguments.plane_at, measures.unit), radius_m);
    if (!plane) return located(plane.error(), arguments.mesh);
    measures.plane = *plane;
  }
  if (arguments.circle_at) {
    const auto circle = fit_circle(mesh, in_metres(*arguments.circle_at, measures.unit), radius_m);
    if (!circle) return located(circle.error(), arguments.mesh);
    measures.circle = *circle;
  }
  return {};
}

Result<void> write_measures(MeshMeasures& measures, const std::filesystem::path& folder) {
  for (std::size_t i = 0; i < measures.sections.size(); ++i) {
    const std::filesystem::path svg = folder / fmt::format("section_{}.svg", i + 1);
    std::filesystem::path dxf = svg;
    dxf.replace_extension(".dxf");
    if (auto done = write_file_atomically(svg, section_svg(measures.sections[i])); !done) return done;
    if (auto done = write_file_atomically(dxf, section_dxf(measures.sections[i])); !done) return done;
    measures.files.push_back(svg);
    measures.files.push_back(dxf);
  }
  measures.files.push_back(folder / "measure.json");
  return write_file_atomically(folder / "measure.json", measures_json(measures));
}

}  // namespace

int measure_command(const MeasureArguments& arguments, const CommonArguments& common) {
  Console console(common.verbosity);
  const bool wants_files = !arguments.output.empty();
  if (wants_files) {
    if (auto writable = check_writable(arguments.output / "measure.json"); !writable) {
      return fail(writable.error(), common);
    }
  }
  const auto read = read_measured_mesh(arguments.mesh, arguments.unit);
  if (!read) return fail(read.error(), common);
  for (const std::string& warning : read->warnings) console.warn(warning);
  MeshMeasures measures;
  measures.file = arguments.mesh;
  measures.unit = read->unit;
  if (arguments.thin) measures.thin_m = arguments.thin->metres(read->unit);
  measure_solid(read->mesh, measures);
  if (auto done = measure_places(read->mesh, arguments, measures); !done) return fail(done.error(), common);
  if (wants_files) {
    if (auto done = write_measures(measures, arguments.output); !done) return fail(done.error(), common);
  }
  return print_result(common.is_json ? measures_json(measures) : measures_lines(measures), common);
}

}  // namespace scanknit
