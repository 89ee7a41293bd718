#include <nlohmann/json.hpp>

#include "app/measure/mesh_measures.h"

namespace scanknit {
namespace {

using MeasureJson = nlohmann::ordered_json;

template <typename Vector>
MeasureJson numbers_json(const Vector& v) {
  MeasureJson json = MeasureJson::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) json.push_back(v[i]);
  return json;
}

MeasureJson or_null(const std::optional<double>& number) {
  return number ? MeasureJson(*number) : MeasureJson();
}

MeasureJson box_json(const OrientedBox& box) {
  return {{"size_m", numbers_json(box.size_m)},
          {"centre_m", numbers_json(box.centre_m)},
          {"axes", {numbers_json(box.axes.col(0)), numbers_json(box.axes.col(1)), numbers_json(box.axes.col(2))}},
          {"volume_m3", box.volume_m3()}};
}

MeasureJson holes_json(const std::vector<Hole>& holes) {
  MeasureJson json = MeasureJson::array();
  for (const Hole& hole : holes) json.push_back({{"edges", hole.edges}, {"length_m", hole.length_m}});
  return json;
}

MeasureJson thickness_json(const MeshMeasures& measures) {
  if (!measures.thickness) return nullptr;
  const WallThickness& walls = *measures.thickness;
  return {{"points", walls.points},
          {"share_measured", walls.share_measured},
          {"min_m", walls.min_m},
          {"thinnest_at_m", numbers_json(walls.thinnest_m)},
          {"p01_m", walls.p01_m},
          {"p05_m", walls.p05_m},
          {"median_m", walls.median_m},
          {"max_m", walls.max_m},
          {"thin_m", or_null(measures.thin_m)},
          {"share_thin", or_null(walls.share_thin)}};
}

MeasureJson section_json(const MeshSection& section) {
  MeasureJson outlines = MeasureJson::array();
  for (const Outline& outline : section.outlines) {
    outlines.push_back({{"length_m", outline.length_m},
                        {"area_m2", outline.is_closed ? MeasureJson(outline.area_m2) : MeasureJson()},
                        {"is_closed", outline.is_closed},
                        {"points", outline.points_m.size()}});
  }
  return {{"normal", numbers_json(section.plane.normal)},
          {"offset_m", section.plane.offset_m},
          {"right", numbers_json(section.plane.right)},
          {"up", numbers_json(section.plane.up)},
          {"min_m", numbers_json(section.min_m)},
          {"max_m", numbers_json(section.max_m)},
          {"length_m", section.length_m},
          {"area_m2", section.open_outlines == 0 ? MeasureJson(section.area_m2) : MeasureJson()},
          {"outlines", outlines}};
}

MeasureJson plane_json(const FittedPlane& plane) {
  return {{"middle_m", numbers_json(plane.middle_m)},
          {"normal", numbers_json(plane.normal)},
          {"offset_m", plane.offset_m},
          {"rms_m", plane.rms_m},
          {"flatness_m", plane.max_m - plane.min_m},
          {"area_m2", plane.area_m2},
          {"share", plane.share}};
}

MeasureJson circle_json(const FittedCircle& circle) {
  return {{"centre_m", numbers_json(circle.centre_m)},
          {"axis", numbers_json(circle.axis)},
          {"radius_m", circle.radius_m},
          {"diameter_m", 2 * circle.radius_m},
          {"rms_m", circle.rms_m},
          {"is_hole", circle.is_hole},
          {"arc_rad", circle.arc_rad},
          {"share", circle.share}};
}

}  // namespace

std::string measures_json(const MeshMeasures& measures) {
  MeasureJson sections = MeasureJson::array(), files = MeasureJson::array();
  for (const MeshSection& section : measures.sections) sections.push_back(section_json(section));
  for (const auto& file : measures.files) files.push_back(file.string());
  const MeshVolume& volume = measures.volume;
  const MeasureJson json = {
      {"file", measures.file.string()},
      {"unit", description_of(measures.unit).name},
      {"vertices", measures.vertices},
      {"triangles", measures.triangles},
      {"bounds_m", {numbers_json(measures.bounds_m.min()), numbers_json(measures.bounds_m.max())}},
      {"oriented_box", box_json(measures.box)},
      {"area_m2", measures.area_m2},
      {"volume_m3", or_null(volume.volume_m3)},
      {"volume_with_covered_holes_m3", or_null(volume.covered_volume_m3)},
      {"is_closed", volume.border_edges == 0},
      {"is_inside_out", volume.is_inside_out},
      {"border_edges", volume.border_edges},
      {"tangled_edges", volume.tangled_edges},
      {"holes", holes_json(measures.holes)},
      {"thickness", thickness_json(measures)},
      {"sections", sections},
      {"plane", measures.plane ? plane_json(*measures.plane) : MeasureJson()},
      {"circle", measures.circle ? circle_json(*measures.circle) : MeasureJson()},
      {"files", files}};
  return json.dump(2, ' ', false, MeasureJson::error_handler_t::replace) + "\n";
}

}  // namespace scanknit
