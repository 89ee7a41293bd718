#include "fusion/silhouette/visual_hull.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "fusion/silhouette/hull_blocks.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using openvdb::Coord;

/// False if the band does not meet the block.
bool carve(const HullBlocks& hull, float truncation_m, NewBlock& block) {
  const auto looks = hull.look_at(block.block.origin);
  float* tsdf = block.tsdf->buffer().data();
  WeightCode* weight = block.weight->buffer().data();
  TsdfLeaf::NodeMaskType known;
  bool is_in_band = false, is_free = true;
  for (unsigned n = 0; n < kBlockVoxels; ++n) {
    const auto [distance_m, seen_by] = looks[n];
    if (seen_by < kFewestSilhouettes) continue;
    known.setOn(n);
    tsdf[n] = distance_m;
    weight[n] = encode_weight(static_cast<float>(seen_by));
    is_in_band = is_in_band || std::abs(distance_m) < truncation_m;
    is_free = is_free && distance_m >= truncation_m;
    block.block.has_matter = block.block.has_matter || distance_m < 0;
  }
  block.block.is_free = is_free && known.isOn();
  block.tsdf->setValueMask(known);
  block.weight->setValueMask(known);
  block.colour->setValueMask(known);
  return is_in_band;
}

}  // namespace

Result<CarveStats> carve_hull(std::span<const SilhouetteView> views, const Eigen::AlignedBox3d& box,
                              TsdfVolume& volume) {
  try {
    const HullBlocks hull(views, volume);
    auto found = hull.in_band(box);
    if (!found) return found.error();
    std::vector<Coord> wanted = *std::move(found);
    CarveStats stats;
    BlockBudget budget = volume.block_budget();
    std::erase_if(wanted, [&](const Coord& origin) { return !budget.admits(origin); });
    stats.is_budget_reached = budget.is_reached();
    std::vector<NewBlock> fresh(wanted.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, wanted.size()), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        NewBlock made(wanted[i], volume.tsdf().background());
        if (carve(hull, volume.tsdf().background(), made)) fresh[i] = std::move(made);
      }
    });
    ++volume.frames;
    for (NewBlock& made : fresh) {
      if (!made.has_leaves()) continue;
      made.block.last_frame = volume.frames;
      made.block.has_changed = true;
      volume.add_block(std::move(made));
      ++stats.blocks_added;
    }
    volume.is_budget_reached = volume.is_budget_reached || stats.is_budget_reached;
    return stats;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while carving; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

}  // namespace scanknit
