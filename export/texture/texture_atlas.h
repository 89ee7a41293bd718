// TextureAtlas: a mesh unfolded into a texture.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "export/texture/texel_raster.h"

namespace scanknit {

/// Texels around each chart that no other chart may use, because filters read them.
inline constexpr int kAtlasGutter = 3;

struct AtlasRequest {
  double texel = 0.001;        ///< side of a texel on the surface, in the mesh's unit
  bool may_be_coarser = true;  ///< use larger texels if the texture would become too large
  int max_side = 4096;         ///< largest side of the texture: a multiple of four in 16..16384
};

/// The mesh's triangles in their order, with new vertices: those of the mesh, in their order, followed by a copy of a
/// vertex for each further chart that it belongs to.
struct TextureAtlas {
  int width = 0, height = 0;
  double texel = 0;
  std::size_t charts = 0;
  std::vector<std::uint32_t> source;    ///< the mesh's vertex of each vertex
  std::vector<TexelPoint> places;       ///< position of each vertex in the texture
  std::vector<Triangle> triangles;      ///< one for each of the mesh's
  std::vector<std::uint32_t> chart_of;  ///< one for each triangle

  /// glTF's texture coordinate: (0, 0) is the outer corner of the first texel, v points down.
  [[nodiscard]] Eigen::Vector2f coordinate(std::size_t vertex) const;
  /// The mesh with the atlas's vertices, without colours.
  [[nodiscard]] Mesh unfolded(const Mesh& mesh) const;
  /// The corners of a triangle in the texture.
  [[nodiscard]] std::array<TexelPoint, 3> corners(std::size_t triangle) const;
};

/// No texel has its centre in two triangles; charts keep 2 * kAtlasGutter texels apart. The same for any number of
/// threads. Errors: kMesh for a mesh without triangles; kBudget when it does not fit; the message says what would fit.
[[nodiscard]] Result<TextureAtlas> build_atlas(const Mesh& mesh, const AtlasRequest& request);

}  // namespace scanknit
