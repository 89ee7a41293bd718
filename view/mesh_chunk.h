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
  std::vector<std::uint8_t> coverage;  ///< of each vertex, 0 to 255; empty: 255 for all
  /// One standard deviation of each vertex, metres; NaN, or empty for all: unknown. Sent in micrometres, rounded up.
  std::vector<float> uncertainty_m = {};
};

/// Makes a message of kind 1: positions in 16 bits, normals in 8. A mesh without normals gets zero normals, one without
/// colours grey. The parts have fewer than 2^32 vertices and indices in all. Rounds positions to multiples of a step:
/// `finest_m` (metres, a power of two), or step_for() of the chunk's extent if that is larger. Chunks with the same
/// step meet without a gap.
[[nodiscard]] std::string chunk_message(std::uint32_t chunk, std::uint32_t revision, std::span<const ChunkPart> parts,
                                        float finest_m = 0);

/// The step with which 16 bits hold an extent: a power of two, metres.
[[nodiscard]] float step_for(float extent_m);

/// Makes a message of kind 2: the chunk is gone.
[[nodiscard]] std::string chunk_gone_message(std::uint32_t chunk, std::uint32_t revision);

/// Makes a message of kind 3: the scanner's picture, a JPEG file.
[[nodiscard]] std::string picture_message(std::uint32_t revision, std::span<const std::uint8_t> jpeg);

}  // namespace scanknit
