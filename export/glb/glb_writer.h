// Writes all GLB files: plain, quantized, compressed, with a texture, in one primitive or several.
#pragma once

#include <cstdint>

#include "core/files/atomic_file.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/export_config.h"
#include "export/placement.h"
#include "export/texture/mesh_texture.h"

namespace scanknit {

/// Viewers fail well below 4 GiB, the limit of the sizes in the file's header.
inline constexpr std::uint64_t kMaxGlbBytes = (1ull << 31) - 1;

/// The content of a GLB. Refers to its parts, which outlive it.
struct GlbContents {
  const Mesh& mesh;
  const Placement& placement;            ///< to metres, Y up
  const MeshTexture* texture = nullptr;  ///< null: none
};

/// Writes glTF 2.0 with one mesh, which has passed the checks of write_mesh(). Writes a normal of zero length
/// (direction unknown) as +Y, because glTF requires unit length. A mesh of more than config.max_vertices_of_a_primitive
/// vertices becomes several primitives: boxes of the mesh, each with its own copies of the vertices on its border; the
/// reader joins them again. config.quantize (KHR_mesh_quantization): positions are rounded to 1/65535 of the longest
/// side of the mesh's box, on one grid for all primitives, normals to 1/127, texture coordinates to 1/65535.
/// config.compress (EXT_meshopt_compression): nothing is rounded, vertices and triangles come in another order. Colours
/// are exact. Errors (kOutput): more than `max_bytes`, compressed or not (checked before any allocation); out of
/// memory; a failed write.
[[nodiscard]] Result<void> write_glb(const GlbContents& contents, const ExportConfig& config, AtomicFile& file,
                                     std::uint64_t max_bytes = kMaxGlbBytes);

}  // namespace scanknit
