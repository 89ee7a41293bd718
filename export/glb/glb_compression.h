// EXT_meshopt_compression, to make GLB files smaller (https://github.com/KhronosGroup/glTF, extensions/2.0/Vendor).
// Private to the GLB writer.
#pragma once

#include <vector>

#include "core/mesh/split_mesh.h"
#include "export/glb/glb_arrays.h"

namespace scanknit {

/// Reorders a part to compress well: neighbouring triangles follow one another, and the vertices have the order of
/// their first use. Vertices without a triangle come last.
[[nodiscard]] MeshPart in_order_of_use(const GlbPart& part);

/// The array's bytes, compressed: mode TRIANGLES for indices, ATTRIBUTES for all others.
[[nodiscard]] std::vector<unsigned char> compressed(const GlbArray& array);

}  // namespace scanknit
