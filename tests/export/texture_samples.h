// Meshes to unfold, and frames to take colours from.
#pragma once

#include <algorithm>
#include <functional>

#include "core/frame.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/png_codec.h"
#include "export/texture/mesh_texture.h"
#include "export/texture/texture_atlas.h"
#include "tests/export/export_samples.h"

namespace scanknit::test {

/// A ramp that winds upwards round the z axis: it looks up everywhere, and lies over itself.
inline Mesh spiral_ramp(int turns = 2) {
  Mesh mesh;
  constexpr int kSteps = 48;
  for (int i = 0; i <= turns * kSteps; ++i) {
    const float a = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / kSteps, z = 0.1f * a;
    mesh.positions_m.emplace_back(0.5f * std::cos(a), 0.5f * std::sin(a), z);
    mesh.positions_m.emplace_back(std::cos(a), std::sin(a), z);
  }
  for (std::uint32_t i = 0; i + 3 < mesh.positions_m.size(); i += 2) {
    mesh.triangles.push_back({i, i + 1, i + 3});
    mesh.triangles.push_back({i, i + 3, i + 2});
  }
  return mesh;
}

/// A square of 0.4 m at z = 1 m that faces a camera at the origin; grey.
inline Mesh wall(int cells = 8) {
  Mesh mesh;
  const float side_m = 0.4f;
  for (int y = 0; y <= cells; ++y) {
    for (int x = 0; x <= cells; ++x) {
      const float n = static_cast<float>(cells);
      mesh.positions_m.emplace_back(side_m * (static_cast<float>(x) / n - 0.5f),
                                    side_m * (static_cast<float>(y) / n - 0.5f), 1.0f);
      mesh.normals.emplace_back(0, 0, -1);
      mesh.colours.push_back({128, 128, 128});
    }
  }
  const auto row = static_cast<std::uint32_t>(cells + 1);
  for (std::uint32_t y = 0; y + 1 < row; ++y) {
    for (std::uint32_t x = 0; x + 1 < row; ++x) {
      const std::uint32_t v = y * row + x;
      mesh.triangles.push_back({v, v + row, v + row + 1});
      mesh.triangles.push_back({v, v + row + 1, v + 1});
    }
  }
  return mesh;
}

/// A camera at the origin that sees, 1 m away, `colour(x_m, y_m)`; 500 pixels to the metre.
inline Frame frame_of_wall(const std::function<Rgb8(double, double)>& colour) {
  Frame frame;
  frame.intrinsics = {320, 240, 500, 500, 159.5, 119.5};
  frame.depth_m = DepthImage(320, 240, 1.0f);
  ColourFrame picture{ColourImage(320, 240), frame.intrinsics};
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const Eigen::Vector3d p = frame.intrinsics.unproject(u, v, 1);
      picture.image.at(u, v) = colour(p.x(), p.y());
    }
  }
  frame.colour = std::move(picture);
  return frame;
}

inline TextureAtlas atlas_of(const Mesh& mesh, double texel) {
  AtlasRequest request;
  request.texel = texel;
  auto atlas = build_atlas(mesh, request);
  EXPECT_TRUE(atlas) << atlas.error().text();
  return atlas ? *std::move(atlas) : TextureAtlas{};
}

/// A picture with a square of `side` texels for each vertex of the mesh, in the vertex's colour, and coordinates in the
/// middle of it. Forty squares wide, which is no square for the meshes of the tests.
struct OwnTexels {
  ColourImage image;
  MeshTexture texture;
};
inline OwnTexels own_texels(const Mesh& mesh, int side = 1, bool is_png = true) {
  constexpr int kColumns = 40;
  const int rows = (static_cast<int>(mesh.colours.size()) + kColumns - 1) / kColumns;
  OwnTexels made{ColourImage(side * kColumns, side * rows), {}};
  for (std::size_t v = 0; v < mesh.colours.size(); ++v) {
    const int column = static_cast<int>(v) % kColumns, row = static_cast<int>(v) / kColumns;
    made.texture.coordinates.emplace_back((static_cast<float>(column) + 0.5f) / kColumns,
                                          (static_cast<float>(row) + 0.5f) / static_cast<float>(rows));
    for (int y = 0; y < side; ++y) {
      std::fill_n(made.image.row(side * row + y).begin() + side * column, side, mesh.colours[v]);
    }
  }
  made.texture.image = *(is_png ? encode_png(made.image, PngEffort::kFast) : encode_jpeg(made.image, 92));
  made.texture.mime = is_png ? "image/png" : "image/jpeg";
  return made;
}

/// In how many triangles each texel has its centre.
inline Image<int> coverage(const TextureAtlas& atlas) {
  Image<int> count(atlas.width, atlas.height, 0);
  for (std::size_t t = 0; t < atlas.triangles.size(); ++t) {
    for_each_texel(atlas.corners(t), [&](int x, int y, const auto&) {
      EXPECT_TRUE(count.contains(x, y));
      if (count.contains(x, y)) ++count.at(x, y);
      return true;
    });
  }
  return count;
}

struct Textured {
  Mesh mesh;
  MeshTexture texture;
};

/// `mesh` under one colour: closed or not, it has seams then.
inline Textured textured(const Mesh& mesh) {
  const TextureAtlas atlas = atlas_of(mesh, 0.02);
  Textured made{atlas.unfolded(mesh), {}};
  for (std::size_t v = 0; v < atlas.source.size(); ++v) made.texture.coordinates.push_back(atlas.coordinate(v));
  made.texture.image = *encode_png(ColourImage(atlas.width, atlas.height, Rgb8{10, 200, 30}), PngEffort::kFast);
  made.texture.mime = "image/png";
  return made;
}

}  // namespace scanknit::test
