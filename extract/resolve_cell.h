// What the signs of a cell's corners leave open: which of its ambiguous faces have their Highs joined, and its tunnel.
#pragma once

#include "extract/blocks/block.h"
#include "extract/cell/cell_table.h"
#include "extract/extract_config.h"

namespace scanknit {

/// The cell at (x, y, z) of a block. `decider` is not one of the tetrahedral ones.
[[nodiscard]] CellEntry resolve_cell(const ValueBlock& values, int x, int y, int z, CornerMask highs, double isovalue,
                                     Decider decider);

}  // namespace scanknit
