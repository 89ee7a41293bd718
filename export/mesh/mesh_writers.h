// The writers of all formats except GLB (export/glb/glb_writer.h). The mesh must have passed the checks of
// write_mesh(): it is not empty, and its indices, attribute lengths and placed positions are valid.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/files/atomic_file.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/placement.h"

namespace scanknit {

class ByteWriter;

/// The parts of PLY and STL files, to write meshes that are not a Mesh in memory.
struct PlyContents {
  std::size_t vertices = 0, triangles = 0;
  bool has_normals = false, has_colours = false, has_uncertainty = false;
};
[[nodiscard]] std::string ply_head(const PlyContents& contents, const Placement& placement);
[[nodiscard]] std::string stl_head(const Placement& placement);  ///< without the following count of triangles
void put_ply_face(const Triangle& triangle, ByteWriter& out);
void put_stl_facet(const std::array<Eigen::Vector3f, 3>& placed_corners, ByteWriter& out);

/// Binary little-endian PLY: x y z [nx ny nz] [red green blue] [uncertainty], colours as sRGB bytes. `uncertainty_m` is
/// empty or has one a vertex.
[[nodiscard]] Result<void> write_ply(const Mesh& mesh, const Placement& placement, std::span<const float> uncertainty_m,
                                     AtomicFile& file);

/// Wavefront OBJ: `v x y z [r g b]`, colours as sRGB in 0..1 (the convention of MeshLab, Blender and others), `vn`.
[[nodiscard]] Result<void> write_obj(const Mesh& mesh, const Placement& placement, AtomicFile& file);

/// The limit of a 3MF file: its model is text, about 100 bytes for each triangle when unpacked.
inline constexpr std::size_t kMax3mfTriangles = 4'000'000;

/// 3MF (core specification 1.3, materials extension's colour group): millimetres, sRGB colours at each corner. Writes
/// the zip archive itself: three deflated entries, the same bytes for the same mesh. Omits triangles that use a vertex
/// twice. Error kOutput for more than `max_triangles`.
[[nodiscard]] Result<void> write_3mf(const Mesh& mesh, const Placement& placement, AtomicFile& file,
                                     std::size_t max_triangles = kMax3mfTriangles);

/// Binary STL; facet normals come from the geometry. The format has no colour.
[[nodiscard]] Result<void> write_stl(const Mesh& mesh, const Placement& placement, AtomicFile& file);

}  // namespace scanknit
