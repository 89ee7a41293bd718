// A textured GLB as the program wrote it, read by other means than our own reader.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "core/mesh.h"

namespace scanknit::test {

struct TexturedMesh {
  Mesh mesh;  ///< in the recording's world, whose y runs down
  std::vector<Eigen::Vector2f> coordinates;
  ColourImage texture;

  /// sRGB, 0..255, bilinear in the texture, at a point of a triangle.
  [[nodiscard]] Eigen::Vector3d texture_colour(const Triangle& triangle, const std::array<float, 3>& weights) const;
};

/// A plain GLB of ours: one primitive, float positions and coordinates, one picture. Throws when it is none.
[[nodiscard]] TexturedMesh read_textured_glb(const std::filesystem::path& path);

}  // namespace scanknit::test
