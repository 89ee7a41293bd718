// The binary messages of the live view (docs/live_view.md): chunks of the mesh, and pictures.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace scanknit {

/// Some of a chunk's triangles, with their own vertices.
struct ChunkPart {
  const Mesh* mesh = nullptr;          ///< never null, well formed
  std::vector<std::uint8_t> coverage;  ///< of each vertex, 0 to 255; empty: all well seen
};

/// A message of kind 1: positions in 16 bits, normals in 8. Where a mesh has no normals, they are zero; without colours
/// it is grey. Fewer than 2^32 vertices and indices in all. Positions are rounded to multiples of a power of two, of at
/// least `finest_m` metres: chunks whose extents' step_for() is no larger meet without a gap.
[[nodiscard]] std::string chunk_message(std::uint32_t chunk, std::uint32_t revision, std::span<const ChunkPart> parts,
                                        float finest_m = 0);

/// The least `finest_m` for which chunks of that extent along an axis are rounded alike.
[[nodiscard]] float step_for(float extent_m);

/// Kind 2: the chunk is gone.
[[nodiscard]] std::string chunk_gone_message(std::uint32_t chunk, std::uint32_t revision);

/// Kind 3: what the scanner sees, a JPEG file.
[[nodiscard]] std::string picture_message(std::uint32_t revision, std::span<const std::uint8_t> jpeg);

}  // namespace scanknit
