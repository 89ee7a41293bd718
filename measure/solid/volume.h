// The volume of a mesh, and why there may be none.
#pragma once

#include <cstddef>
#include <optional>

#include "core/mesh.h"

namespace scanknit {

struct MeshVolume {
  /// Of a closed mesh. Parts that overlap count twice, and cavities are left out, if their triangles face into them.
  std::optional<double> volume_m3;
  bool is_inside_out = false;  ///< its triangles are clockwise seen from outside
  /// Of an open one, with each hole covered from its rim to the middle of that: an approximation.
  std::optional<double> covered_volume_m3;
  std::size_t border_edges = 0;
  std::size_t tangled_edges = 0;  ///< where sheets meet so that none has an inside; more than 0: neither volume
};

/// The mesh must be well formed.
[[nodiscard]] MeshVolume measure_volume(const Mesh& mesh);

}  // namespace scanknit
