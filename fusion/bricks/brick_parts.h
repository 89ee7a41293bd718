// BrickPart: what is fused at once when a volume is larger than the memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/result.h"
#include "fusion/bricks/brick_plan.h"
#include "fusion/volume/region_set.h"

namespace scanknit {

struct BrickPart {
  RegionSet regions;
  std::vector<FrameRun> frames;  ///< that may change it, ascending; no two of them touch
  std::size_t most_bytes = 0;    ///< of memory that its blocks may need
};

/// One part for each brick, a cube of `brick_voxels`^3 voxels (a multiple of kRegionVoxels) that frames may observe.
/// Errors (kBudget): one of them may need more than `max_bytes`.
[[nodiscard]] Result<std::vector<BrickPart>> parts_of_bricks(const BrickPlan& plan, int brick_voxels,
                                                             std::size_t max_bytes);

/// Few parts, each of which stays within `max_bytes`: regions that frames come to one after the other are together, as
/// they have frames in common. Every region fits into kLeastMemoryBudgetMib.
[[nodiscard]] std::vector<BrickPart> parts_within(const BrickPlan& plan, std::size_t max_bytes);

/// The frames that are in any of `runs`, ascending; no two of the result touch.
[[nodiscard]] std::vector<FrameRun> joined_runs(std::vector<FrameRun> runs);

/// The number of frames in runs.
[[nodiscard]] std::size_t count_frames(const std::vector<FrameRun>& runs);

}  // namespace scanknit
