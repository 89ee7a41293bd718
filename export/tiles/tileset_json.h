// The tileset.json of 3D Tiles 1.1.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "export/export_config.h"

namespace scanknit {

/// A tile that was written, and those that take its place.
struct WrittenTile {
  std::string uri;          ///< of its GLB, from tileset.json
  Eigen::AlignedBox3f box;  ///< of its vertices and those of all below it, as the GLB has them: +Y up, metres
  double error_m = 0;       ///< at least that of each child
  std::vector<WrittenTile> children = {};
};

/// East, north and up at a place on the Earth's ellipsoid, in coordinates from its centre (WGS 84, ECEF).
[[nodiscard]] Eigen::Isometry3d T_earth_local(double longitude_deg, double latitude_deg, double height_m);

/// The document. Its coordinates are +Z up, as 3D Tiles turns the content of glTF: (x, -z, y). `triangles`: of all
/// leaves.
[[nodiscard]] std::string tileset_json(const WrittenTile& root, std::size_t triangles, const ExportConfig& config);

}  // namespace scanknit
