// What the mesh readers share: polygons become fans, and the result is checked before anyone trusts it.
#pragma once

#include <cstdint>
#include <span>

#include "core/limits.h"
#include "core/mesh.h"
#include "core/result.h"

namespace scanknit {

[[nodiscard]] inline Error input_error(std::string what) {
  return {ErrorCode::kInput, std::move(what)};
}

/// Appends the fan of triangles of a polygon; fewer than three corners (a point, a line) add nothing.
[[nodiscard]] Result<void> add_polygon(std::span<const std::uint32_t> corners, const Limits& limits, Mesh& mesh);

/// Refuses an index out of range and a position that is not finite; a normal that is not finite becomes zero, which
/// stands for "unknown".
[[nodiscard]] Result<Mesh> finish_mesh(Mesh mesh);

}  // namespace scanknit
