// What tinygltf does for this room: in a module, libscanknit_glb_reader.so, since few commands read a GLB.
#pragma once

#include <string_view>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/system/module.h"
#include "export/mesh/read_mesh.h"

namespace scanknit {

struct GlbReader {
  /// As read_glb(); `notes` may be null.
  Result<Mesh> (*read)(std::string_view bytes, const Limits& limits, MeshNotes* notes);
};

/// Error (kInternal): load_module()'s.
[[nodiscard]] inline Result<const GlbReader*> load_glb_reader() {
  return load_module<GlbReader>("glb_reader", "Install scanknit again; it needs Debian's libtinygltf2d");
}

}  // namespace scanknit
