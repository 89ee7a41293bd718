// Writes a mesh as 3D Tiles 1.1: a folder with tileset.json and GLB tiles, coarse ones for far away, fine ones for
// near.
#pragma once

#include <cstddef>
#include <filesystem>

#include "core/mesh.h"
#include "core/result.h"
#include "export/export_config.h"
#include "export/placement_plan.h"

namespace scanknit {

/// Of a tile: about 2 MB, so that one is there within a moment, and a screen needs a few dozen.
inline constexpr std::size_t kMaxTrianglesOfATile = 65536;

/// Writes `folder`, all or nothing; an older folder of tiles is replaced as a whole. The mesh has passed the checks of
/// write_mesh(). The tiles are an octree: leaves have the mesh's triangles, each whole and once, at most
/// `most_triangles` of them; the tiles above have half of their children's triangles or `most_triangles`, whichever is
/// less, simplified so that vertices which other tiles use stay where they are. Tiles of any levels that show every
/// place once therefore have no gap: where the mesh is closed, so are they, bit by bit. geometricError is in metres, 0
/// for leaves, and adds up from there, wrong colours included: simplify_tile(). GLB as write_glb() makes it, but not
/// quantized: grids of several tiles would leave gaps. The same bytes for any number of threads. Memory: 16 bytes a
/// triangle, and a few tiles for each thread. Before the folder has its name, the root is read back and compared.
/// Errors: kOutput, also for a folder there that is not empty and has no tileset.json; kBudget when the memory does not
/// suffice.
[[nodiscard]] Result<WrittenFile> write_tiles(const Mesh& mesh, const PlacementPlan& plan, const ExportConfig& config,
                                              const std::filesystem::path& folder,
                                              std::size_t most_triangles = kMaxTrianglesOfATile);

/// check_writable() for such a folder. Errors: kOutput.
[[nodiscard]] Result<void> check_tiles_writable(const std::filesystem::path& folder);

}  // namespace scanknit
