// What a mesh file has in addition to its mesh.
#pragma once

#include <string>
#include <vector>

namespace scanknit {

struct MeshNotes {
  std::vector<std::string> warnings;  ///< parts that were not read, such as a texture that cannot be decoded
  /// Vertices are split along the seams of a texture (stitch_seams() joins them).
  bool has_texture_coordinates = false;
};

}  // namespace scanknit
