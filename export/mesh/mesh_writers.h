// The writers of each format but GLB (export/glb/glb_writer.h). All expect what write_mesh() has checked: a mesh that
// is not empty and whose indices, attribute lengths and placed positions are right.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/files/atomic_file.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/glb/placement.h"

namespace scanknit {

class ByteWriter;

/// The parts of PLY and STL files, for meshes that are written from elsewhere than a Mesh.
struct PlyContents {
  std::size_t vertices = 0, triangles = 0;
  bool has_normals = false, has_colours = false;
};
[[nodiscard]] std::string ply_head(const PlyContents& contents, const Placement& placement);
[[nodiscard]] std::string stl_head(const Placement& placement);  ///< without the count of triangles that follows it
void put_ply_face(const Triangle& triangle, ByteWriter& out);
void put_stl_facet(const std::array<Eigen::Vector3f, 3>& placed_corners, ByteWriter& out);

/// Binary little-endian PLY: x y z [nx ny nz] [red green blue], colours as sRGB bytes.
[[nodiscard]] Result<void> write_ply(const Mesh& mesh, const Placement& placement, AtomicFile& file);

/// Wavefront OBJ: `v x y z [r g b]`, colours as sRGB in 0..1 (the convention of MeshLab, Blender and others), `vn`.
[[nodiscard]] Result<void> write_obj(const Mesh& mesh, const Placement& placement, AtomicFile& file);

/// A 3MF file beyond this is refused: its model is text, some 100 bytes a triangle once it is unpacked.
inline constexpr std::size_t kMax3mfTriangles = 4'000'000;

/// 3MF (core specification 1.3, materials extension's colour group): millimetres, sRGB colours at each corner. The zip
/// is ours: three deflated entries, the same bytes for the same mesh. Triangles that name a vertex twice are left out.
/// kOutput beyond `max_triangles`.
[[nodiscard]] Result<void> write_3mf(const Mesh& mesh, const Placement& placement, AtomicFile& file,
                                     std::size_t max_triangles = kMax3mfTriangles);

/// Binary STL; facet normals come from the geometry. The format has no colour.
[[nodiscard]] Result<void> write_stl(const Mesh& mesh, const Placement& placement, AtomicFile& file);

}  // namespace scanknit
