// Reading a mesh: PLY (ASCII, binary of either byte order), OBJ (polygons are fanned), STL (ASCII, binary), GLB.
#pragma once

#include <filesystem>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"
#include "export/mesh/mesh_notes.h"

namespace scanknit {

/// The mesh in the file's own coordinates and unit (STL: what the numbers say). Vertices of an STL that are bit-equal
/// are welded. GLB colours are turned from linear to sRGB; node transforms are applied; primitives of a
/// mesh are joined where they were cut (stitch_borders.h); a textured vertex has the colour of its texel. `notes` are
/// added to. Errors (kInput): unreadable, not the format, counts beyond `limits`, an index out of range, a position
/// that is not finite, truncated. A normal that is not finite becomes zero: unknown.
[[nodiscard]] Result<Mesh> read_mesh(const std::filesystem::path& path, const Limits& limits = {},
                                     MeshNotes* notes = nullptr);

}  // namespace scanknit
