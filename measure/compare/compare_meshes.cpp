#include "measure/compare/compare_meshes.h"

#include <tbb/parallel_invoke.h>

#include "measure/area_points.h"
#include "measure/compare/signed_distance.h"

namespace scanknit {
namespace {

std::vector<Eigen::Vector3d> vertices_of(const Mesh& mesh) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(mesh.positions_m.size());
  for (const Eigen::Vector3f& p : mesh.positions_m) points.push_back(p.cast<double>());
  return points;
}

}  // namespace

ComparedMeshes compare_meshes(const Mesh& mesh, const Mesh& reference, std::optional<double> tolerance_m,
                              std::size_t area_points) {
  std::optional<SignedDistance> from_mesh, from_reference;
  std::vector<Eigen::Vector3d> mesh_area, reference_area;
  tbb::parallel_invoke([&] { from_mesh.emplace(mesh); }, [&] { from_reference.emplace(reference); },
                       [&] { mesh_area = positions_of(spread_over_area(mesh, area_points)); },
                       [&] { reference_area = positions_of(spread_over_area(reference, area_points)); });
  ComparedMeshes compared;
  compared.mesh = {from_mesh->edges(), from_mesh->is_inside_out()};
  compared.reference = {from_reference->edges(), from_reference->is_inside_out()};
  MeshDeviation& deviation = compared.deviation;
  deviation.vertices_m = from_reference->at(vertices_of(mesh));
  const std::vector<double> area_m = from_reference->at(mesh_area);
  const std::vector<double> reference_area_m = from_mesh->at(reference_area);
  deviation.vertices = deviation_stats(deviation.vertices_m);
  deviation.area = deviation_stats(area_m);
  deviation.reference_area = deviation_stats(reference_area_m);
  deviation.histogram = deviation_histogram(area_m, scale_end_m(deviation.area));
  Eigen::AlignedBox3d reference_box;
  for (const Eigen::Vector3f& p : reference.positions_m) reference_box.extend(p.cast<double>());
  deviation.regions = deviation_regions(mesh_area, area_m, reference_box, tolerance_m);
  if (tolerance_m) {
    compared.beyond = ToleranceShares{share_beyond(deviation.vertices_m, *tolerance_m),
                                      share_beyond(area_m, *tolerance_m), share_beyond(reference_area_m, *tolerance_m)};
  }
  return compared;
}

}  // namespace scanknit
