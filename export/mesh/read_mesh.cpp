#include "export/mesh/read_mesh.h"

#include <fmt/format.h>

#include "core/files/located.h"
#include "core/files/read_file.h"
#include "export/glb/glb_reader.h"
#include "export/mesh/mesh_builder.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/mesh_readers.h"
#include "export/step/step_reader.h"

namespace scanknit {
namespace {

Result<Mesh> read_as(MeshFormat format, std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  switch (format) {
    case MeshFormat::kGlb: return read_glb(bytes, limits, notes);
    case MeshFormat::kPly: return read_ply(bytes, limits, notes);
    case MeshFormat::kObj: return read_obj(bytes, limits);
    case MeshFormat::kStl: return read_stl(bytes, limits);
    case MeshFormat::kStep: return read_step(bytes, limits, notes);
    case MeshFormat::kTiles: return input_error("3D Tiles are written only: take the GLB or PLY of the same mesh");
    case MeshFormat::kThreeMf:
      return input_error("3MF is written only, for slicers: take the GLB or PLY of the same mesh");
  }
  return input_error("a format without a reader");
}

}  // namespace

Result<Mesh> read_glb(std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  const auto reader = load_glb_reader();
  if (!reader) return reader.error();
  return (*reader)->read(bytes, limits, notes);
}

Result<Mesh> parse_mesh(std::string_view bytes, MeshFormat format, const Limits& limits, MeshNotes* notes) {
  try {
    return read_as(format, bytes, limits, notes).and_then(finish_mesh);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "the mesh does not fit into memory"};
  }
}

Result<Mesh> read_mesh(const std::filesystem::path& path, const Limits& limits, MeshNotes* notes) {
  const std::optional<MeshFormat> format = mesh_format(path);
  if (!format) {
    return Error{
        ErrorCode::kInput,
        fmt::format("unknown mesh extension '{}'; known are {}", path.extension().string(), kReadableMeshExtensions),
        path.string()};
  }
  const auto bytes = read_text_file(path, limits.max_mesh_bytes);
  if (!bytes) return bytes.error();
  auto mesh = parse_mesh(*bytes, *format, limits, notes);
  if (!mesh) return located(mesh.error(), path);
  return mesh;
}

}  // namespace scanknit
