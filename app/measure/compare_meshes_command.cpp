#include "app/measure/compare_meshes_command.h"

#include <fmt/format.h>

#include "app/exit_codes.h"
#include "app/measure/align_meshes.h"
#include "app/measure/deviation_files.h"
#include "app/measure/deviation_text.h"
#include "app/measure/measured_mesh.h"
#include "core/files/atomic_file.h"
#include "core/system/beside.h"

namespace scanknit {
namespace {

/// Errors (kInput) where the sizes differ as units do, and nobody said which unit the reference has.
Result<void> check_units(const MeasuredMesh& mesh, const MeasuredMesh& reference, const DistanceArguments& arguments,
                         Console& console) {
  const double size_m = diagonal_m(mesh.mesh), reference_size_m = diagonal_m(reference.mesh);
  const double times = reference_size_m / size_m;
  const bool is_given = mesh.is_unit_given || reference.is_unit_given;
  const auto other = unit_that_fits(size_m, reference_size_m, reference.unit);
  const auto mesh_unit = unit_that_fits(reference_size_m, size_m, mesh.unit);
  const std::string sizes =
      fmt::format("the reference is {:.4g} times as large as the mesh ({:.4g} mm and {:.4g} mm across)", times,
                  reference_size_m * 1000, size_m * 1000);
  if (other && !reference.is_unit_given && !reference.is_unit_stated) {
    return Error{
        ErrorCode::kInput,
        fmt::format("{}: read as {}, it seems to be in {}; say --reference-unit {}, or {} if that is right, or "
                    "--mesh-unit if the mesh is in another unit than {}",
                    sizes, description_of(reference.unit).plural, description_of(*other).plural,
                    description_of(*other).name, description_of(reference.unit).name, description_of(mesh.unit).plural),
        arguments.truth.string()};
  }
  if (mesh_unit && !is_given && !mesh.is_unit_stated) {
    return Error{ErrorCode::kInput,
                 fmt::format("{}: the mesh, read as {}, seems to be in {}; say --mesh-unit {}, or {} if that is right",
                             sizes, description_of(mesh.unit).plural, description_of(*mesh_unit).plural,
                             description_of(*mesh_unit).name, description_of(mesh.unit).name),
                 arguments.mesh.string()};
  }
  const bool is_stated = mesh.is_unit_stated || reference.is_unit_stated;
  if (differ_as_inch_and_millimetre(size_m, reference_size_m) && !is_given && !is_stated) {
    return Error{ErrorCode::kInput,
                 sizes +
                     ": as if one was in inches and the other in millimetres; say both --mesh-unit and "
                     "--reference-unit",
                 arguments.truth.string()};
  }
  constexpr double kSurprising = 5;
  if (times > kSurprising || times < 1 / kSurprising) console.warn(sizes);
  return {};
}

void warn_of_sides(const Comparison& comparison, Console& console) {
  const std::string file = comparison.reference.path.string();
  const SideNotes& reference = comparison.compared.reference;
  if (reference.is_inside_out) console.warn(file + ": its triangles face inwards; they are taken the other way round");
  if (reference.edges.border > 0) {
    console.warn(fmt::format("{}: open ({} border edges): signs say before or behind its front, not outside or inside",
                             file, reference.edges.border));
  }
  if (reference.edges.tangled > 0) {
    console.warn(
        fmt::format("{}: {} edges are not those of two triangles that face the same way: signs there may be wrong",
                    file, reference.edges.tangled));
  }
  if (comparison.placement.is_ambiguous) {
    console.warn(
        "other placements of the mesh fit as well (a symmetric shape?): the distances of one of them are given");
  }
}

ComparedFile described(const std::filesystem::path& path, const MeasuredMesh& read) {
  return {path, read.unit, read.mesh.positions_m.size(), read.mesh.triangles.size()};
}

void move_mesh(Mesh& mesh, const Pose& T_reference_mesh) {
  if (T_reference_mesh.isApprox(Pose::Identity(), 0)) return;
  for (Eigen::Vector3f& p : mesh.positions_m) p = (T_reference_mesh * p.cast<double>()).cast<float>();
  for (Eigen::Vector3f& n : mesh.normals) n = T_reference_mesh.linear().cast<float>() * n;
}

}  // namespace

int compare_meshes_command(const DistanceArguments& arguments, const CommonArguments& common) {
  const ComparisonArguments& wanted = arguments.comparison;
  Console console(common.verbosity);
  if (arguments.trajectory) {
    return fail({ErrorCode::kUsage, "--trajectory is for the folder of a synthetic scene, not for a mesh"}, common);
  }
  const bool wants_files = !wanted.output.empty();
  if (wants_files) {
    if (auto writable = check_writable(wanted.output / "deviation.ply"); !writable)
      return fail(writable.error(), common);
  }
  auto reading = beside([&] { return read_measured_mesh(arguments.truth, wanted.reference_unit); });
  auto mesh = read_measured_mesh(arguments.mesh, wanted.mesh_unit);
  const auto reference = reading.get();
  if (!mesh) return fail(mesh.error(), common);
  if (!reference) return fail(reference.error(), common);
  for (const auto& warnings : {mesh->warnings, reference->warnings}) {
    for (const std::string& warning : warnings) console.warn(warning);
  }
  if (auto alike = check_units(*mesh, *reference, arguments, console); !alike) return fail(alike.error(), common);
  const auto placement = align_meshes(*mesh, *reference, wanted);
  if (!placement) return fail(placement.error(), common);
  move_mesh(mesh->mesh, placement->T_reference_mesh);
  std::optional<double> tolerance_m;
  if (wanted.tolerance) tolerance_m = wanted.tolerance->metres(mesh->unit);

  Comparison comparison{described(arguments.mesh, *mesh),
                        described(arguments.truth, *reference),
                        wanted.alignment,
                        *placement,
                        compare_meshes(mesh->mesh, reference->mesh, tolerance_m),
                        tolerance_m,
                        wanted.allowed_share,
                        {}};
  warn_of_sides(comparison, console);
  if (wants_files) {
    if (auto done = write_deviation_files(comparison, mesh->mesh, wanted.output); !done)
      return fail(done.error(), common);
  }
  const int printed = print_result(common.is_json ? comparison_json(comparison) : comparison_lines(comparison), common);
  if (printed != kExitOk || comparison.is_within_tolerance().value_or(true)) return printed;
  const ToleranceShares& beyond = *comparison.compared.beyond;
  return fail({ErrorCode::kMesh,
               fmt::format("{:.3g} % of the vertices and {:.3g} % of the area are beyond the tolerance of {}",
                           beyond.vertices * 100, beyond.area * 100, in_millimetres(*tolerance_m)),
               arguments.mesh.string()},
              common);
}

}  // namespace scanknit
