// EXT_meshopt_compression, to make GLB files smaller (https://github.com/KhronosGroup/glTF, extensions/2.0/Vendor).
// Private to the GLB writer.
#pragma once

#include <vector>

#include "core/mesh/split_mesh.h"
#include "export/glb/glb_arrays.h"

namespace scanknit {

/// The same part with triangles that lie close together next to each other, and its vertices in the order in which
/// these triangles name them: so ordered, it compresses well. Vertices of no triangle come last.
[[nodiscard]] MeshPart in_order_of_use(const MeshPart& part);

/// The array's bytes, compressed: mode TRIANGLES for indices, ATTRIBUTES for all others.
[[nodiscard]] std::vector<unsigned char> compressed(const GlbArray& array);

}  // namespace scanknit
