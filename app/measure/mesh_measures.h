// All that `measure` found out about a mesh.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/measure/measured_mesh.h"
#include "export/measure/holes.h"
#include "measure/fit/circle_fit.h"
#include "measure/fit/plane_fit.h"
#include "measure/section/mesh_section.h"
#include "measure/solid/oriented_box.h"
#include "measure/solid/thickness.h"
#include "measure/solid/volume.h"

namespace scanknit {

struct MeshMeasures {
  std::filesystem::path file;
  MeshUnit unit = MeshUnit::kMetre;
  std::size_t vertices = 0, triangles = 0;
  Eigen::AlignedBox3d bounds_m;
  OrientedBox box;
  double area_m2 = 0;
  MeshVolume volume;
  std::vector<Hole> holes;
  std::optional<WallThickness> thickness;  ///< nothing: the mesh has no inside
  std::optional<double> thin_m;
  std::vector<MeshSection> sections;
  std::optional<FittedPlane> plane;
  std::optional<FittedCircle> circle;
  std::vector<std::filesystem::path> files;  ///< that were written
};

[[nodiscard]] std::string measures_json(const MeshMeasures& measures);
[[nodiscard]] std::string measures_lines(const MeshMeasures& measures);

}  // namespace scanknit
