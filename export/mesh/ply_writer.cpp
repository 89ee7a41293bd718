#include <fmt/format.h>

#include "core/version.h"
#include "export/mesh/byte_writer.h"
#include "export/mesh/mesh_writers.h"

namespace scanknit {

std::string ply_head(const PlyContents& contents, const Placement& placement) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment ScanKnit {}\ncomment positions in {}{}{}\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
      kVersion, placement.unit, contents.has_colours ? ", colours sRGB" : "",
      contents.has_uncertainty ? "\ncomment uncertainty: one standard deviation in metres, nan where unknown" : "",
      contents.vertices);
  if (contents.has_normals) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (contents.has_colours) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (contents.has_uncertainty) text += "property float uncertainty\n";
  // int, not uint: it is what every reader knows, and writers keep indices below 2^31.
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", contents.triangles);
  return text;
}

void put_ply_face(const Triangle& triangle, ByteWriter& out) {
  out.put(std::uint8_t{3});
  for (const std::uint32_t index : triangle) out.put(static_cast<std::int32_t>(index));
}

Result<void> write_ply(const Mesh& mesh, const Placement& placement, std::span<const float> uncertainty_m,
                       AtomicFile& file) {
  ByteWriter out(file);
  const PlyContents contents{mesh.positions_m.size(), mesh.triangles.size(), !mesh.normals.empty(),
                             !mesh.colours.empty(), !uncertainty_m.empty()};
  out.text(ply_head(contents, placement));
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    out.put(placement.position(mesh.positions_m[i]));
    if (!mesh.normals.empty()) out.put(placement.normal(mesh.normals[i]));
    if (!mesh.colours.empty()) {
      out.put(mesh.colours[i].r);
      out.put(mesh.colours[i].g);
      out.put(mesh.colours[i].b);
    }
    if (!uncertainty_m.empty()) out.put(uncertainty_m[i]);
  }
  for (const Triangle& triangle : mesh.triangles) put_ply_face(triangle, out);
  return out.finish();
}

}  // namespace scanknit
