// fill_gaps: a visual hull fills what depth left of a thing.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <span>
#include <vector>

#include "core/result.h"
#include "fusion/silhouette/depth_gaps.h"
#include "fusion/silhouette/visual_hull.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// Voxels of one block that the hull filled.
struct FilledBlock {
  openvdb::Coord origin;
  GapBlock::Voxels voxels;
};

struct GapFill {
  std::vector<FilledBlock> blocks;
  std::size_t voxels_inside = 0;   ///< those of them that are matter now
  bool is_budget_reached = false;  ///< blocks were left out
};

/// Gives the gaps within the hull its signed distance, and those around it that share a cell with one of these, so that
/// its surface closes. The weight is the count of the views. A voxel that the volume knows (weight above 0) is never
/// changed, and where nothing is within the hull, nothing is filled. The same bits for any number of threads. Errors:
/// kBudget when memory runs out; a full fusion.memory_budget is none.
[[nodiscard]] Result<GapFill> fill_gaps(const DepthGaps& gaps, TsdfVolume& volume);

/// Paints what was filled as paint_hull() does, and nothing else.
void paint_filled(std::span<const ColourOfView> views, const GapFill& fill, TsdfVolume& volume);

}  // namespace scanknit
