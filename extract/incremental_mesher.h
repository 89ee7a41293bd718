// IncrementalMesher: keeps the surface of a changing volume up to date, leaf by leaf.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "core/field_view.h"
#include "core/mesh.h"
#include "core/result.h"
#include "extract/blocks/block.h"
#include "extract/blocks/vdb_blocks.h"
#include "extract/extract_config.h"

namespace scanknit {

/// The triangles of one leaf's 8^3 cells, with its own copies of the vertices that it shares with other patches.
struct MeshPatch {
  Eigen::Vector3i origin = Eigen::Vector3i::Zero();  ///< index coordinates of the leaf's first voxel
  std::uint64_t revision = 0;  ///< IncrementalMesher::revision() after the update that last changed `mesh`
  Mesh mesh;                   ///< never empty
};

struct BlockOrder {
  bool operator()(const Eigen::Vector3i& a, const Eigen::Vector3i& b) const { return is_before(a, b); }
};

/// Patches by origin. A patch keeps its address as long as its leaf meets the surface.
using MeshPatches = std::map<Eigen::Vector3i, MeshPatch, BlockOrder>;

/// All patches together have the triangles of extract_surface() with the same configuration, bit for bit, except the
/// normals of vertices with a zero gradient, which come only from the patch's triangles. Ignores
/// `min_component_triangles` and `memory_budget_mib`. The same patches for any number of threads.
class IncrementalMesher {
 public:
  /// The view's grids must outlive the mesher; it reads their transform now. Makes no patches: give the first update()
  /// all leaves. kConfig: as for extract_surface(); a tetrahedral decider; a field with active tiles.
  [[nodiscard]] static Result<IncrementalMesher> create(const FieldView& view, const ExtractConfig& config);

  /// `changed`: the first voxels (index coordinates, multiples of 8) of all leaves in which a value, weight, colour or
  /// active state changed since the last call, or that appeared or vanished; any order. Meshes them and those of their
  /// neighbours whose patches may depend on them: 7, or all 26 with normals, colours or Decider::kKnit. No step goes
  /// over the whole volume, though finding a patch takes time logarithmic in their number.
  ///
  /// Returns the origins of the patches that are new, different or gone, sorted by is_before.
  /// Errors: kConfig for an active tile, or a leaf at the end of the 32-bit coordinates; kBudget when memory runs out;
  /// kInput for what OpenVDB throws.
  /// After an error the patches are as before, and the same leaves are still to be given.
  [[nodiscard]] Result<std::vector<Eigen::Vector3i>> update(std::span<const Eigen::Vector3i> changed);

  [[nodiscard]] const MeshPatches& patches() const { return patches_; }

  /// The number of updates that changed a patch.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

  /// All patches as one mesh, in the order of their origins. Not welded: patches do not share vertices. kMesh for more
  /// than 2^32 - 2 vertices. Throws std::bad_alloc.
  [[nodiscard]] Result<Mesh> mesh() const;

 private:
  IncrementalMesher(const FieldView& view, const ExtractConfig& config, VdbBlocks volume);

  [[nodiscard]] std::vector<Eigen::Vector3i> remesh(std::span<const Eigen::Vector3i> changed);

  FieldView view_;
  ExtractConfig config_;
  VdbBlocks volume_;  ///< with an empty list of blocks
  MeshPatches patches_;
  std::uint64_t revision_ = 0;
};

}  // namespace scanknit
