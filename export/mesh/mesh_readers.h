// The readers of each format: pure functions of the file's bytes, so that each can be fuzzed. Errors are kInput and
// name no file; read_mesh() adds it. The results must still pass finish_mesh().
#pragma once

#include <string_view>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/read_mesh.h"

namespace scanknit {

[[nodiscard]] Result<Mesh> read_ply(std::string_view bytes, const Limits& limits, MeshNotes* notes = nullptr);
[[nodiscard]] Result<Mesh> read_obj(std::string_view bytes, const Limits& limits);
[[nodiscard]] Result<Mesh> read_stl(std::string_view bytes, const Limits& limits);
/// Also kInternal, when its module cannot be opened.
[[nodiscard]] Result<Mesh> read_glb(std::string_view bytes, const Limits& limits, MeshNotes* notes = nullptr);

/// Reads and finishes: what read_mesh() does once it has the bytes.
[[nodiscard]] Result<Mesh> parse_mesh(std::string_view bytes, MeshFormat format, const Limits& limits,
                                      MeshNotes* notes = nullptr);

}  // namespace scanknit
