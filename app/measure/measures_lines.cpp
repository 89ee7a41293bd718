#include <fmt/format.h>

#include <numbers>

#include "app/measure/mesh_measures.h"

namespace scanknit {
namespace {

constexpr double kLineMmPerM = 1000;

std::string point_text(const Eigen::Vector3d& p_m) {
  const Eigen::Vector3d p = p_m * kLineMmPerM;
  return fmt::format("{:.4f}, {:.4f}, {:.4f} mm", p.x(), p.y(), p.z());
}

std::string direction_text(const Eigen::Vector3d& direction) {
  return fmt::format("{:.5f}, {:.5f}, {:.5f}", direction.x(), direction.y(), direction.z());
}

std::string volume_line(const MeshVolume& volume) {
  constexpr double kMm3PerM3 = 1e9;
  if (volume.volume_m3) {
    return fmt::format("Volume     {:.7g} mm3{}\n", *volume.volume_m3 * kMm3PerM3,
                       volume.is_inside_out ? " (its triangles face inwards)" : "");
  }
  if (volume.covered_volume_m3) {
    return fmt::format("Volume     none, because the mesh is open; with its holes covered about {:.5g} mm3\n",
                       *volume.covered_volume_m3 * kMm3PerM3);
  }
  return fmt::format("Volume     none: at {} edges triangles meet that leave no inside\n", volume.tangled_edges);
}

std::string holes_lines(const std::vector<Hole>& holes) {
  constexpr std::size_t kMostShown = 5;
  std::string text = fmt::format("Holes      {}\n", holes.size());
  for (std::size_t i = 0; i < holes.size() && i < kMostShown; ++i) {
    text += fmt::format("           rim of {:.5g} mm, {} edges\n", holes[i].length_m * kLineMmPerM, holes[i].edges);
  }
  if (holes.size() > kMostShown) text += fmt::format("           and {} more\n", holes.size() - kMostShown);
  return text;
}

std::string thickness_lines(const MeshMeasures& measures) {
  if (!measures.thickness) return "Thickness  none: the mesh has no inside\n";
  const WallThickness& walls = *measures.thickness;
  std::string text =
      fmt::format("Thickness  median {:.4f} mm, 5 % below {:.4f}, 1 % below {:.4f}, least {:.4f} at {}\n",
                  walls.median_m * kLineMmPerM, walls.p05_m * kLineMmPerM, walls.p01_m * kLineMmPerM,
                  walls.min_m * kLineMmPerM, point_text(walls.thinnest_m));
  if (walls.share_measured < 1) {
    text += fmt::format("           {:.3g} % of the surface has no wall behind it\n", (1 - walls.share_measured) * 100);
  }
  if (walls.share_thin) {
    text += fmt::format("           {:.3g} % of the surface is thinner than {:.4g} mm\n", *walls.share_thin * 100,
                        *measures.thin_m * kLineMmPerM);
  }
  return text;
}

std::string section_line(const MeshSection& section) {
  const Eigen::Vector2d size_mm = (section.max_m - section.min_m) * kLineMmPerM;
  if (section.outlines.empty()) return "Section    empty: the plane does not meet the mesh\n";
  std::string text = fmt::format("Section    {} outlines, {:.6g} mm, {:.5g} x {:.5g} mm", section.outlines.size(),
                                 section.length_m * kLineMmPerM, size_mm.x(), size_mm.y());
  if (section.open_outlines > 0) return text + fmt::format("; {} of them open: no area\n", section.open_outlines);
  return text + fmt::format(", area {:.6g} mm2\n", section.area_m2 * kLineMmPerM * kLineMmPerM);
}

std::string plane_line(const FittedPlane& plane) {
  return fmt::format("Plane      normal {}, through {}, rms {:.4f} mm, flatness {:.4f} mm\n",
                     direction_text(plane.normal), point_text(plane.middle_m), plane.rms_m * kLineMmPerM,
                     (plane.max_m - plane.min_m) * kLineMmPerM);
}

std::string circle_line(const FittedCircle& circle) {
  return fmt::format("Circle     diameter {:.4f} mm of a {}, centre {}, axis {}, rms {:.4f} mm, {:.0f} degrees seen\n",
                     2 * circle.radius_m * kLineMmPerM, circle.is_hole ? "hole" : "rod", point_text(circle.centre_m),
                     direction_text(circle.axis), circle.rms_m * kLineMmPerM, circle.arc_rad * 180 / std::numbers::pi);
}

}  // namespace

std::string measures_lines(const MeshMeasures& measures) {
  const Eigen::Vector3d size_mm = measures.bounds_m.sizes() * kLineMmPerM, box_mm = measures.box.size_m * kLineMmPerM;
  std::string text = fmt::format("{} ({} triangles, in {})\n", measures.file.string(), measures.triangles,
                                 description_of(measures.unit).plural);
  text += fmt::format("Bounds     {:.6g} x {:.6g} x {:.6g} mm along x, y, z\n", size_mm.x(), size_mm.y(), size_mm.z());
  text += fmt::format("Box        {:.6g} x {:.6g} x {:.6g} mm, turned\n", box_mm.x(), box_mm.y(), box_mm.z());
  text += fmt::format("Area       {:.7g} mm2\n", measures.area_m2 * kLineMmPerM * kLineMmPerM);
  text += volume_line(measures.volume) + holes_lines(measures.holes) + thickness_lines(measures);
  for (const MeshSection& section : measures.sections) text += section_line(section);
  if (measures.plane) text += plane_line(*measures.plane);
  if (measures.circle) text += circle_line(*measures.circle);
  for (const auto& file : measures.files) text += fmt::format("Written    {}\n", file.string());
  return text;
}

}  // namespace scanknit
