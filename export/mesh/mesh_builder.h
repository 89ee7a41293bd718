// The common parts of mesh readers: triangulates polygons as fans, and checks the result.
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

/// The mesh of triangles that are three corners each: bit-equal corners become one vertex. Vertices are numbered in the
/// order of their first corner. Sorting, not hashing: no input makes it slow.
[[nodiscard]] Mesh weld(std::span<const Eigen::Vector3f> corners);

/// Errors (kInput): an index out of range, a position that is not finite. Sets a normal that is not finite to zero,
/// which means "unknown".
[[nodiscard]] Result<Mesh> finish_mesh(Mesh mesh);

}  // namespace scanknit
