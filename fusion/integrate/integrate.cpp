#include "fusion/integrate/integrate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "fusion/integrate/band_blocks.h"
#include "fusion/integrate/integrate_part.h"
#include "fusion/integrate/observation.h"
#include "fusion/integrate/update_block.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/new_block.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using openvdb::Coord;

constexpr float kNowhere_m = 1e30f;  // behind everything

/// What a thread has at hand for the next block.
struct Spare {
  NewBlock block;                                  ///< in which nothing is known, or without leaves
  std::array<ColourCode, kBlockVoxels> colours{};  ///< none, for a block that has no memory for its own
};

/// A block that a frame concerns.
struct BlockTask {
  Coord origin;
  float far_m;                                   ///< behind this z the frame says nothing of it
  BlockIndex::Number known = BlockIndex::kNone;  ///< its number in the volume
  NewBlock added = {};                           ///< while it has none, if the frame says something of it
};

/// Applies one frame to blocks. Holds what is the same for all voxels.
class BlockUpdate {
 public:
  BlockUpdate(const Observation& observation, const Pose& T_world_camera, TsdfVolume& volume)
      : view_(observation.planes(), observation.intrinsics(), T_world_camera.inverse(), volume.config()),
        volume_(volume) {
    view_.colour = observation.colours(volume.frames);
    if (!observation.clear_m().empty()) view_.clear_m = observation.clear_m().pixels().data();
  }

  /// Blocks lie far apart, behind two pointers: the memory is asked for each some blocks ahead.
  void prefetch(const std::vector<BlockTask>& tasks, std::size_t i) const {
    const auto ahead = [&](std::size_t steps) -> const VolumeBlock* {
      if (i + steps >= tasks.size() || tasks[i + steps].known == BlockIndex::kNone) return nullptr;
      return &volume_.index().blocks()[tasks[i + steps].known];
    };
    if (const VolumeBlock* block = ahead(6)) __builtin_prefetch(block);
    if (const VolumeBlock* block = ahead(4)) {
      prefetch_bytes(block->tsdf, sizeof(TsdfLeaf));
      prefetch_bytes(block->weight, sizeof(WeightLeaf));
      prefetch_bytes(block->colour, sizeof(ColourLeaf));
    }
    if (const VolumeBlock* block = ahead(1)) {
      prefetch_bytes(block->tsdf->buffer().data(), kBlockVoxels * sizeof(float));
      prefetch_bytes(block->weight->buffer().data(), kBlockVoxels * sizeof(WeightCode));
    }
  }

  /// The spare block becomes the task's if it needs one.
  void apply(BlockTask& task, Spare& spare) const {
    if (task.known != BlockIndex::kNone) {
      VolumeBlock& block = volume_.index().blocks()[task.known];
      const bool had_colours = has_own_colours(*block.colour);
      const bool has_changed = apply(block, task.far_m, spare.colours);
      block.has_changed = block.has_changed || has_changed;
      if (!had_colours && has_own_colours(*block.colour)) volume_.count_colours_of_a_block();
      return;
    }
    if (!spare.block.has_leaves()) spare.block = NewBlock(task.origin, volume_.tsdf().background());
    spare.block.move_to(task.origin);
    if (!apply(spare.block.block, task.far_m, spare.colours)) return;
    task.added = std::move(spare.block);
    task.added.block.is_free = false;  // a new block is known to be free from its second frame on
  }

 private:
  static void prefetch_bytes(const void* first, std::size_t bytes) {
    constexpr std::size_t kCacheLine = 64;
    for (std::size_t byte = 0; byte < bytes; byte += kCacheLine) {
      __builtin_prefetch(static_cast<const char*>(first) + byte, /*for writing*/ 1);
    }
  }
  /// True if the frame said something of it. `no_colours` are lent to a block that has none.
  [[nodiscard]] bool apply(VolumeBlock& block, float far_m, std::array<ColourCode, kBlockVoxels>& no_colours) const {
    const Eigen::Vector3d first(block.origin.x(), block.origin.y(), block.origin.z());
    const bool has_colours = has_own_colours(*block.colour);
    BlockChange change;
    update_block(view_, view_.place(first, far_m),
                 {block.tsdf->buffer().data(), block.weight->buffer().data(),
                  has_colours ? block.colour->buffer().data() : no_colours.data()},
                 change);
    if (change.has_colour && !has_colours) {
      std::copy(no_colours.begin(), no_colours.end(), block.colour->buffer().data());
      no_colours.fill(ColourCode{});
    }
    block.is_free = change.is_free;
    block.has_matter = block.has_matter || change.has_matter;

    TsdfLeaf::NodeMaskType observed;
    std::uint64_t any = 0;
    for (std::size_t x = 0; x < change.observed.size(); ++x) {
      observed.getWord<std::uint64_t>(static_cast<openvdb::Index>(x)) = change.observed[x];
      any |= change.observed[x];
    }
    observed |= block.tsdf->getValueMask();
    if (observed != block.tsdf->getValueMask()) {
      block.tsdf->setValueMask(observed);
      block.weight->setValueMask(observed);
      block.colour->setValueMask(observed);
    }
    return any != 0;
  }

  FrameView view_;
  TsdfVolume& volume_;
};

/// The blocks of the band, without new ones that the budget does not allow.
std::vector<BlockTask> band_tasks(const std::vector<BandBlock>& blocks, TsdfVolume& volume, IntegrateStats& stats) {
  std::vector<BlockTask> tasks(blocks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size()), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      tasks[i] = {blocks[i].origin, blocks[i].far_m, volume.index().find(blocks[i].origin)};
  });
  BlockBudget budget = volume.block_budget();
  std::erase_if(tasks, [&](const BlockTask& task) {
    if (task.known != BlockIndex::kNone) {
      volume.index().blocks()[task.known].last_frame = volume.frames;
      return false;
    }
    return !budget.admits(task.origin);
  });
  stats.is_budget_reached = budget.is_reached();
  return tasks;
}

/// Known blocks outside the band that hold space in front of it, but for those in which there is nothing to carve.
void append_blocks_in_front(const SpaceInFront& front, const TsdfVolume& volume, std::vector<BlockTask>& tasks) {
  const auto regions = volume.index().regions();
  const auto blocks = volume.index().blocks();
  std::vector<std::vector<BlockIndex::Number>> found(regions.size());
  tbb::parallel_for(std::size_t{0}, regions.size(), [&](std::size_t r) {
    if (!front.meets(regions[r]->origin, BlockIndex::kRegionVoxels)) return;
    for (const BlockIndex::Number number : regions[r]->blocks) {
      const VolumeBlock& block = blocks[number];
      if (block.last_frame == volume.frames || block.is_free) continue;
      if (front.meets(block.origin, kBlockEdgeVoxels)) found[r].push_back(number);
    }
  });
  for (const auto& numbers : found) {
    for (const BlockIndex::Number number : numbers) tasks.push_back({blocks[number].origin, kNowhere_m, number});
  }
}

/// New blocks in which something was observed become the volume's. Returns their number.
std::size_t add_new_blocks(std::vector<BlockTask>& tasks, TsdfVolume& volume) {
  std::size_t added = 0;
  for (BlockTask& task : tasks) {
    if (!task.added.has_leaves()) continue;
    task.added.block.last_frame = volume.frames;
    task.added.block.has_changed = true;
    volume.add_block(std::move(task.added));
    ++added;
  }
  return added;
}

/// `part`: only its blocks; null: all. `make_room` may be null.
Result<IntegrateStats> integrate_blocks(const Frame& frame, const Pose& T_world_camera, const RegionSet* part,
                                        const MakeRoom* make_room, TsdfVolume& volume) {
  if (!is_rigid(T_world_camera)) return not_rigid();
  try {
    const Observation observation(frame, volume.config());
    const double voxel_size_m = volume.config().voxel_size_m;
    if (!is_indexable(observation, T_world_camera, voxel_size_m)) return too_far_from_origin();
    const std::vector<BandBlock> band = find_band_blocks(observation, T_world_camera, voxel_size_m, part);
    std::optional<SpaceInFront> front;
    if (volume.config().carve_free_space) front.emplace(observation, T_world_camera, voxel_size_m);
    if (make_room != nullptr) {
      if (auto made = (*make_room)(band, front ? &*front : nullptr); !made) return made.error();
    }
    ++volume.frames;
    IntegrateStats stats;
    auto tasks = band_tasks(band, volume, stats);
    if (front) append_blocks_in_front(*front, volume, tasks);
    const BlockUpdate update(observation, T_world_camera, volume);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, tasks.size()), [&](const auto& range) {
      Spare spare;
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        update.prefetch(tasks, i);
        update.apply(tasks[i], spare);
      }
    });

    stats.blocks_touched = tasks.size();
    stats.blocks_added = add_new_blocks(tasks, volume);
    volume.is_budget_reached = volume.is_budget_reached || stats.is_budget_reached;
    return stats;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while integrating a frame; a larger fusion.voxel_size needs less"};
  } catch (const openvdb::Exception& e) {
    return Error{ErrorCode::kInternal, std::string("OpenVDB: ") + e.what()};
  }
}

}  // namespace

Result<IntegrateStats> integrate(const Frame& frame, const Pose& T_world_camera, TsdfVolume& volume) {
  return integrate_blocks(frame, T_world_camera, nullptr, nullptr, volume);
}

Result<IntegrateStats> integrate_with_room(const Frame& frame, const Pose& T_world_camera, const MakeRoom& make_room,
                                           TsdfVolume& volume) {
  return integrate_blocks(frame, T_world_camera, nullptr, &make_room, volume);
}

Result<IntegrateStats> integrate_part(const Frame& frame, const Pose& T_world_camera, std::uint32_t number,
                                      const RegionSet& part, TsdfVolume& volume) {
  volume.frames = number - 1;
  return integrate_blocks(frame, T_world_camera, &part, nullptr, volume);
}

}  // namespace scanknit
