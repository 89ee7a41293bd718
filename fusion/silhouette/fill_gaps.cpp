#include "fusion/silhouette/fill_gaps.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
#include <new>
#include <string>
#include <unordered_map>
#include <utility>

#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using openvdb::Coord;

/// Which voxels of all blocks are within the hull.
class Inside {
 public:
  explicit Inside(std::span<const GapBlock> blocks) {
    for (const GapBlock& block : blocks) {
      if (block.inside.any()) blocks_[block.origin] = &block;
    }
  }

  /// Those of `block.around` that share a cell with a voxel within the hull.
  [[nodiscard]] GapBlock::Voxels beside(const GapBlock& block) const {
    GapBlock::Voxels beside;
    const Neighbourhood near(*this, block.origin);
    if (near.is_empty()) return beside;
    for (int n = 0; n < static_cast<int>(kBlockVoxels); ++n) {
      const auto offset = static_cast<std::size_t>(n);
      if (block.around[offset]) beside[offset] = near.is_beside(n >> 6, n >> 3 & 7, n & 7);
    }
    return beside;
  }

 private:
  [[nodiscard]] const GapBlock* find(const Coord& origin) const {
    const auto found = blocks_.find(origin);
    return found == blocks_.end() ? nullptr : found->second;
  }

  /// A block and the 26 around it.
  class Neighbourhood {
   public:
    Neighbourhood(const Inside& all, const Coord& origin) {
      for (int k = 0; k < 27; ++k) {
        const auto step = [](int blocks) { return kBlockEdgeVoxels * (blocks - 1); };
        blocks_[static_cast<std::size_t>(k)] = all.find(origin.offsetBy(step(k / 9), step(k / 3 % 3), step(k % 3)));
        is_empty_ = is_empty_ && blocks_[static_cast<std::size_t>(k)] == nullptr;
      }
    }
    [[nodiscard]] bool is_empty() const { return is_empty_; }
    [[nodiscard]] bool is_beside(int x, int y, int z) const {
      for (int k = 0; k < 27; ++k) {
        if (holds(x + k / 9 - 1, y + k / 3 % 3 - 1, z + k % 3 - 1)) return true;
      }
      return false;
    }

   private:
    /// Coordinates from -1 to 8, from the block's origin.
    [[nodiscard]] bool holds(int x, int y, int z) const {
      const auto block_of = [](int at) { return (at + kBlockEdgeVoxels) / kBlockEdgeVoxels; };
      const GapBlock* block = blocks_[static_cast<std::size_t>(9 * block_of(x) + 3 * block_of(y) + block_of(z))];
      return block != nullptr && block->inside[static_cast<std::size_t>((x & 7) << 6 | (y & 7) << 3 | (z & 7))];
    }

    std::array<const GapBlock*, 27> blocks_{};
    bool is_empty_ = true;
  };

  std::unordered_map<Coord, const GapBlock*> blocks_;
};

/// Writes the gaps among `voxels` into the leaves of a block.
void write(const GapBlock& gaps, const GapBlock::Voxels& voxels, VolumeBlock& block) {
  float* tsdf = block.tsdf->buffer().data();
  WeightCode* weight = block.weight->buffer().data();
  TsdfLeaf::NodeMaskType known = block.tsdf->getValueMask();
  for (unsigned n = 0; n < kBlockVoxels; ++n) {
    if (!voxels[n]) continue;
    known.setOn(n);
    tsdf[n] = gaps.distance_m[n];
    weight[n] = encode_weight(static_cast<float>(gaps.seen_by[n]));
    block.has_matter = block.has_matter || gaps.distance_m[n] < 0;
  }
  block.tsdf->setValueMask(known);
  block.weight->setValueMask(known);
  block.colour->setValueMask(known);
  block.is_free = false;
  block.has_changed = true;
}

/// What to fill of one block.
struct FillTask {
  const GapBlock* gaps;
  FilledBlock filled;
};

std::vector<FillTask> fill_tasks(std::span<const GapBlock> blocks) {
  const Inside inside(blocks);
  std::vector<FillTask> tasks(blocks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      tasks[i] = {&blocks[i], {blocks[i].origin, blocks[i].inside | inside.beside(blocks[i])}};
    }
  });
  std::erase_if(tasks, [](const FillTask& task) { return task.filled.voxels.none(); });
  return tasks;
}

}  // namespace

Result<GapFill> fill_gaps(const DepthGaps& gaps, TsdfVolume& volume) {
  try {
    GapFill fill;
    BlockBudget budget = volume.block_budget();
    for (FillTask& task : fill_tasks(gaps.blocks())) {
      const Coord& origin = task.filled.origin;
      const BlockIndex::Number number = volume.index().find(origin);
      if (number != BlockIndex::kNone) {
        write(*task.gaps, task.filled.voxels, volume.index().blocks()[number]);
      } else if (budget.admits(origin)) {
        NewBlock made(origin, volume.tsdf().background());
        made.block.last_frame = volume.frames;
        write(*task.gaps, task.filled.voxels, made.block);
        volume.add_block(std::move(made));
      } else {
        continue;
      }
      fill.voxels_inside += task.gaps->inside.count();
      fill.blocks.push_back(std::move(task.filled));
    }
    fill.is_budget_reached = budget.is_reached();
    volume.is_budget_reached = volume.is_budget_reached || fill.is_budget_reached;
    return fill;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while filling gaps; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

}  // namespace scanknit
