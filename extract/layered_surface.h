// Extracts the surface of a volume that is read a few layers of blocks at a time.
#pragma once

#include <cstddef>
#include <span>

#include "core/field_view.h"
#include "core/result.h"
#include "extract/extract_config.h"
#include "extract/extract_surface.h"

namespace scanknit {

/// The blocks of 8^3 voxels whose lowest voxels have the same x.
struct BlockLayer {
  int x = 0;               ///< index coordinate, a multiple of 8
  std::size_t blocks = 0;  ///< how many
};

/// A volume in layers.
class LayeredField {
 public:
  virtual ~LayeredField() = default;

  /// By x; those without blocks are left out.
  [[nodiscard]] virtual std::span<const BlockLayer> layers() const = 0;

  /// A view of the blocks with begin_x <= x < end_x, valid until the next call. All views have the same transform, and
  /// colours if one of them has.
  [[nodiscard]] virtual Result<FieldView> read(int begin_x, int end_x) = 0;

  /// Frees what was read last.
  virtual void let_go() = 0;
};

/// The very surface that extract_surface() gives for the whole volume: the same vertices and triangles in the same
/// order, with the same bits. Reads as many layers at a time as have `blocks_at_once` blocks, one at least, and three
/// more: the one before, for normals, and the two after, whose vertices the triangles share. The mesh is in memory as a
/// whole. Errors: those of the field and of extract_surface(); kConfig for a tetrahedral decider.
[[nodiscard]] Result<Surface> extract_surface(LayeredField& field, const ExtractConfig& config,
                                              std::size_t blocks_at_once);

}  // namespace scanknit
