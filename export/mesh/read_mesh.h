// Reads a mesh: PLY (ASCII, binary in both byte orders), OBJ (triangulates polygons as fans), STL (ASCII, binary), GLB,
// and the surfaces of a STEP model.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

/// What a mesh file has in addition to its mesh.
struct MeshNotes {
  std::vector<std::string> warnings;  ///< parts that were not read, such as a texture that cannot be decoded
  /// Vertices are split along the seams of a texture.
  bool has_texture_coordinates = false;
  /// Of each vertex, metres, as write_mesh() writes it; NaN where unknown. Empty: the file has none.
  std::vector<float> uncertainty_m = {};
};

/// The mesh in the file's own coordinates and unit (STL: the plain numbers). Welds bit-equal vertices of an STL. For a
/// GLB, converts colours from linear to sRGB, applies node transforms, joins the primitives of a mesh where they were
/// cut, and gives a textured vertex the colour of its texel. A STEP model is in millimetres, whatever unit it states.
/// Adds to `notes`. Errors (kInput): unreadable, not the format, counts beyond `limits`, an index out of range, a
/// position that is not finite, truncated; kBudget: it does not fit into memory. A normal that is not finite becomes
/// zero: unknown.
[[nodiscard]] Result<Mesh> read_mesh(const std::filesystem::path& path, const Limits& limits = {},
                                     MeshNotes* notes = nullptr);

}  // namespace scanknit
