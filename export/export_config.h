// ExportConfig: which files to write, and how. The keys of `export:` in YAML.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/axes.h"

namespace scanknit {

enum class Material {
  kLit,    ///< shaded; metallicFactor 0, roughnessFactor 1
  kUnlit,  ///< KHR_materials_unlit: exactly the colours the camera saw
};

enum class TextureFormat {
  kOff,   ///< colours at the vertices
  kPng,   ///< exact
  kJpeg,  ///< smaller
};

/// The largest primitive of a GLB: about two million triangles, 60 MB. Viewers were measured to load so much at once
/// within a second or two; with several primitives, a viewer need not draw those outside of the picture.
inline constexpr std::size_t kMaxVerticesOfAPrimitive = 1u << 20;

/// Where the origin of the files' world is on the Earth (WGS 84); its x axis points east, and the axis that points up,
/// up. For 3D Tiles.
struct Georeference {
  std::optional<double> longitude_deg, latitude_deg;  ///< both, or neither: the place is not known
  double height_m = 0;                                ///< above the ellipsoid
};

struct ExportConfig {
  std::vector<std::string> formats = {"glb", "ply"};  ///< for an output folder: some of glb ply obj stl 3mf tiles
  std::optional<UpAxis> world_up;  ///< up axis of the recording's world; nothing: the recording's own
  std::optional<UpAxis> up;  ///< turn PLY and OBJ so that this axis is up; nothing: the recording's world, untouched
  Material material = Material::kLit;
  bool quantize = false;                        ///< GLB: KHR_mesh_quantization
  bool compress = false;                        ///< GLB: EXT_meshopt_compression
  TextureFormat texture = TextureFormat::kOff;  ///< GLB: baked from the colour frames
  int texture_size = 4096;                      ///< largest side of the texture, texels
  std::optional<double> texel_size_m;           ///< side of a texel on the surface; nothing: as fine as the frames are
  Georeference georeference;
  bool preview = true;
  bool uncertainty = false;  ///< of each vertex: a property of PLY, and a picture
  std::size_t max_vertices_of_a_primitive = kMaxVerticesOfAPrimitive;  ///< GLB; no key, for tests of small meshes
};

}  // namespace scanknit
