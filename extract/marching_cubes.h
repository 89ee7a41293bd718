// Marching cubes over blocks.
#pragma once

#include "core/result.h"
#include "extract/block.h"
#include "extract/extract_config.h"
#include "extract/extract_surface.h"

namespace scanknit {

/// Two passes, each parallel over the blocks: the first counts every block's vertices and triangles, a prefix sum in
/// the order of the blocks gives each its place, the second writes. Nothing is shared while writing, so the mesh has
/// the same bits for any number of threads. Between the passes each block keeps a BlockRecord of some 300 bytes. Does
/// not remove components. Error: kMesh past 2^32 - 2 vertices. Throws std::bad_alloc.
[[nodiscard]] Result<Surface> march_cubes(const BlockSource& source, const ExtractConfig& config, bool inside_is_high);

}  // namespace scanknit
