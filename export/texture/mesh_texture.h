// MeshTexture: what a textured GLB has beside its mesh.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace scanknit {

struct MeshTexture {
  std::vector<Eigen::Vector2f> coordinates;  ///< one a vertex, in 0..1; glTF's: v runs down
  std::vector<std::uint8_t> image;           ///< a PNG or JPEG file
  std::string mime;                          ///< "image/png" or "image/jpeg"
};

}  // namespace scanknit
