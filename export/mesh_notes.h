// What a mesh file has beside its mesh.
#pragma once

#include <string>
#include <vector>

namespace scanknit {

struct MeshNotes {
  std::vector<std::string> warnings;  ///< what was left out, such as a texture that cannot be decoded
  bool has_texture_coordinates =
      false;  ///< vertices are split along the seams of a texture (stitch_seams() joins them)
};

}  // namespace scanknit
