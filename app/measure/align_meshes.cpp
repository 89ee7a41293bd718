#include "app/measure/align_meshes.h"

#include "core/files/located.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "measure/area_points.h"
#include "measure/compare/fit_meshes.h"
#include "measure/compare/point_pairs.h"
#include "measure/compare/shape_search.h"

namespace scanknit {
namespace {

Result<Pose> placement_by_pairs(const std::filesystem::path& file, MeshUnit mesh_unit, MeshUnit reference_unit) {
  const auto text = read_text_file(file, Limits{}.max_text_bytes);
  if (!text) return text.error();
  auto pairs = parse_point_pairs(*text);
  if (!pairs) return located(pairs.error(), file);
  for (PointPair& pair : *pairs) {
    pair.on_mesh *= description_of(mesh_unit).metres;
    pair.on_reference *= description_of(reference_unit).metres;
  }
  auto placed = fit_pairs(*pairs);
  return placed ? placed : located(placed.error(), file);
}

Result<Pose> placement_by_matrix(const std::filesystem::path& file, MeshUnit reference_unit) {
  const auto text = read_text_file(file, Limits{}.max_text_bytes);
  if (!text) return text.error();
  auto placed = parse_rigid_matrix(*text, description_of(reference_unit).metres);
  return placed ? placed : located(placed.error(), file);
}

Result<Pose> given_placement(const MeasuredMesh& mesh, const MeasuredMesh& reference,
                             const ComparisonArguments& arguments) {
  if (arguments.pairs) return placement_by_pairs(*arguments.pairs, mesh.unit, reference.unit);
  if (arguments.matrix) return placement_by_matrix(*arguments.matrix, reference.unit);
  return Pose(Pose::Identity());
}

}  // namespace

Result<MeshPlacement> align_meshes(const MeasuredMesh& mesh, const MeasuredMesh& reference,
                                   const ComparisonArguments& arguments) {
  constexpr std::size_t kFitPoints = 20'000;
  MeshPlacement placement;
  if (arguments.alignment == MeshAlignment::kShape) {
    const ShapePlacement found = find_by_shape(mesh.mesh, reference.mesh);
    placement = {found.T_reference_mesh, found.is_ambiguous};
  } else {
    const auto given = given_placement(mesh, reference, arguments);
    if (!given) return given.error();
    placement.T_reference_mesh = *given;
  }
  if (arguments.alignment != MeshAlignment::kGiven) {
    const auto points = positions_of(spread_over_area(mesh.mesh, kFitPoints));
    placement.T_reference_mesh = fit_points(points, SignedDistance(reference.mesh), placement.T_reference_mesh);
  }
  return placement;
}

}  // namespace scanknit
