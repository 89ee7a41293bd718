// MeshTexture: what a textured GLB has in addition to its mesh.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scanknit {

struct MeshTexture {
  std::vector<Eigen::Vector2f> coordinates;  ///< one for each vertex, in 0..1, as in glTF: v points down
  std::vector<std::uint8_t> image;           ///< a PNG or JPEG file
  std::string mime;                          ///< "image/png" or "image/jpeg"
};

}  // namespace scanknit
