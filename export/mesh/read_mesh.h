// Reading a mesh: PLY (ASCII, binary of either byte order), OBJ (polygons are fanned), STL (ASCII, binary), GLB.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

/// What a mesh file has beside its mesh.
struct MeshNotes {
  std::vector<std::string> warnings;  ///< what was left out, such as a texture that cannot be decoded
  /// Vertices are split along the seams of a texture.
  bool has_texture_coordinates = false;
};

/// The mesh in the file's own coordinates and unit (STL: what the numbers say). Vertices of an STL that are bit-equal
/// are welded. GLB colours are turned from linear to sRGB; node transforms are applied; primitives of a
/// mesh are joined where they were cut; a textured vertex has the colour of its texel. `notes` are
/// added to. Errors (kInput): unreadable, not the format, counts beyond `limits`, an index out of range, a position
/// that is not finite, truncated. A normal that is not finite becomes zero: unknown.
[[nodiscard]] Result<Mesh> read_mesh(const std::filesystem::path& path, const Limits& limits = {},
                                     MeshNotes* notes = nullptr);

}  // namespace scanknit
