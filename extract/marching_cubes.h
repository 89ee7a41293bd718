// Marching cubes over blocks.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh.h"
#include "core/result.h"
#include "extract/blocks/block.h"
#include "extract/blocks/classified_blocks.h"
#include "extract/cell/case_histogram.h"
#include "extract/extract_config.h"
#include "extract/vertex_numbering.h"
#include "extract/vertex_sampler.h"

namespace scanknit {

struct MeshSize {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

/// Indices are 32-bit, and GLB keeps the last value for itself.
inline constexpr std::size_t kMaxMeshVertices = 0xFFFFFFFEu;
[[nodiscard]] Error too_many_vertices();

/// A run of blocks in a source's list.
struct BlockRange {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

/// Two passes, each parallel over the blocks: the first counts every block's vertices and triangles, a prefix sum in
/// the order of the blocks gives each its place, the second writes. Writers share nothing, so that the mesh has the
/// same bits for any number of threads. Between the passes a block needs two bits for each voxel, and about 350 bytes
/// more if it meets the surface. The source and the configuration must outlive it; the decider is not a tetrahedral
/// one. Throws std::bad_alloc.
class MarchingCubes {
 public:
  /// Classifies all samples of the source.
  MarchingCubes(const BlockSource& source, const ExtractConfig& config, bool is_inside_high);

  /// The first pass over some blocks; `histogram` gets their cells.
  void count(BlockRange blocks, CaseHistogram& histogram);

  /// Numbers the vertices of all counted blocks in order, the first with `first_vertex`.
  void number(std::size_t first_vertex);

  /// The size of blocks that were counted and numbered.
  [[nodiscard]] MeshSize size_of(BlockRange blocks) const;

  /// The second pass over some blocks. `mesh` gets only their vertices and triangles; indices count from the first
  /// vertex of the whole mesh. The neighbouring blocks towards +x, +y, +z must have been counted too.
  void write(BlockRange blocks, Mesh& mesh) const;

 private:
  [[nodiscard]] BlockRecord count_block(std::size_t block, const Neighbours& neighbours,
                                        CaseHistogram& histogram) const;
  void prefault_part(BlockRange blocks, const BlockRecord& first, Mesh& mesh) const;
  void write_block(const BlockRecord& record, const Neighbours& neighbours, const BlockRecord& first, Mesh& mesh) const;

  const BlockSource& source_;
  const ExtractConfig& config_;
  bool turns_triangles_;
  SamplingFrame frame_;
  ClassifiedBlocks signs_;
  std::vector<std::vector<BlockRecord>> records_;  ///< one list for each task of the first pass
  std::vector<const BlockRecord*> record_of_;      ///< by block; null if it does not meet the surface
};

}  // namespace scanknit
