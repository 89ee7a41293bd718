// ExportConfig: what is written and how. The keys of `export:` in YAML.
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

/// Of a GLB: about two million triangles, some 60 MB. As much as viewers were seen to load as one within a second or
/// two; a viewer can leave out a part whose box is not in the picture.
inline constexpr std::size_t kMaxVerticesOfAPrimitive = 1u << 20;

struct ExportConfig {
  std::vector<std::string> formats = {"glb", "ply"};  ///< written when the output is a folder; of glb ply obj stl 3mf
  std::optional<UpAxis> world_up;  ///< which axis of the recording's world is up; nothing: what the recording says
  std::optional<UpAxis> up;  ///< turn PLY and OBJ so that this axis is up; nothing: the recording's world, untouched
  Material material = Material::kLit;
  bool quantize = false;                        ///< GLB: KHR_mesh_quantization
  bool compress = false;                        ///< GLB: EXT_meshopt_compression
  TextureFormat texture = TextureFormat::kOff;  ///< GLB: baked from the colour frames
  int texture_size = 4096;                      ///< its longest side at most, texels
  std::optional<double> texel_size_m;           ///< side of a texel on the surface; nothing: as fine as the frames are
  bool preview = true;
  std::size_t max_vertices_of_a_primitive = kMaxVerticesOfAPrimitive;  ///< GLB; no key, for tests of small meshes
};

}  // namespace scanknit
