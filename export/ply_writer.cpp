#include <fmt/format.h>

#include "core/version.h"
#include "export/byte_writer.h"
#include "export/mesh_writers.h"

namespace scanknit {
namespace {

std::string header(const Mesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment ScanKnit {}\ncomment positions in metres, colours sRGB\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n",
      kVersion, mesh.positions_m.size());
  if (!mesh.normals.empty()) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.colours.empty()) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  // int, not uint: it is what every reader knows, and write_mesh() keeps indices below 2^31.
  text += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.size());
  return text;
}

}  // namespace

Result<void> write_ply(const Mesh& mesh, const Placement& placement, AtomicFile& file) {
  ByteWriter out(file);
  out.text(header(mesh));
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    out.put(placement.position(mesh.positions_m[i]));
    if (!mesh.normals.empty()) out.put(placement.normal(mesh.normals[i]));
    if (!mesh.colours.empty()) {
      out.put(mesh.colours[i].r);
      out.put(mesh.colours[i].g);
      out.put(mesh.colours[i].b);
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    out.put(std::uint8_t{3});
    for (const std::uint32_t index : triangle) out.put(static_cast<std::int32_t>(index));
  }
  return out.finish();
}

}  // namespace scanknit
