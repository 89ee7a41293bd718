// Reads a folder of 3D Tiles, and checks it against the rules of the specification that concern what we write.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace scanknit::test {

/// +Z up.
struct ReadTile {
  std::string uri;
  Mesh mesh;
  Eigen::AlignedBox3d box;
  double error_m = 0;
  std::vector<ReadTile> children;
};

/// Fails the test where the folder is not as the schema of 3D Tiles 1.1 wants it (OGC 22-025r4: required properties,
/// their types and limits, no others), where a box does not hold its tile and all below it, or where an error is less
/// than a child's. Turns the content as the specification says.
[[nodiscard]] ReadTile read_tileset(const std::filesystem::path& folder);

}  // namespace scanknit::test
