#include "fusion/bricks/paged_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/system/freed_memory.h"
#include "fusion/bricks/brick_file.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using openvdb::Coord;

constexpr std::uint64_t kJob = 0;  // pages belong to nobody else
// To write a block and read it again costs about 15 microseconds; to decode and filter a frame once more, 10 ms.
constexpr std::size_t kMostBlocksOfAFrame = 700;
constexpr std::uint32_t kFramesBeforeGivingUp = 16;
constexpr std::size_t kMostTightFrames = 3;

bool meets_any(const SpaceInFront& front, const Coord& region, const BlocksOfRegion& blocks) {
  if (blocks.none() || !front.meets(region, kRegionVoxels)) return false;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i] && front.meets(block_of(region, i), kBlockEdgeVoxels)) return true;
  }
  return false;
}

/// The blocks that are not known to be free.
BlocksOfRegion blocks_to_carve(const BlockIndex::Region& region, const TsdfVolume& volume) {
  BlocksOfRegion blocks;
  for (const BlockIndex::Number number : region.blocks) {
    const VolumeBlock& block = volume.index().blocks()[number];
    if (!block.is_free) blocks.set(number_in_region(block.origin));
  }
  return blocks;
}

RegionSet regions_of(std::span<const BandBlock> band) {
  RegionSet regions;
  for (const BandBlock& block : band) regions.insert(region_of(block.origin));
  return regions;
}

}  // namespace

Result<PagedVolume> PagedVolume::create(const FusionConfig& config, const std::filesystem::path& folder) {
  auto volume = TsdfVolume::create(config);
  if (!volume) return volume.error();
  return PagedVolume(*std::move(volume), folder);
}

Result<IntegrateStats> PagedVolume::integrate(const Frame& frame, const Pose& T_world_camera) {
  return integrate_with_room(
      frame, T_world_camera,
      [this](std::span<const BandBlock> band, const SpaceInFront* front) { return make_room(band, front); }, volume_);
}

Result<void> PagedVolume::make_room(std::span<const BandBlock> band, const SpaceInFront* front) {
  RegionSet needed = regions_of(band);
  std::vector<Coord> wanted;
  for (const auto& [region, page] : pages_) {
    if (page.is_in_memory) continue;
    if (needed.contains(region) || (front != nullptr && meets_any(*front, region, page.to_carve)))
      wanted.push_back(region);
  }
  const std::size_t budget = volume_.config().memory_budget_mib << 20;
  if (bytes_with(band, wanted) > budget) {
    if (full_since_ == 0) full_since_ = volume_.frames + 1;
    if (front != nullptr) {
      for (const auto& region : volume_.index().regions()) {
        if (meets_any(*front, region->origin, blocks_to_carve(*region, volume_))) needed.insert(region->origin);
      }
    }
    if (auto paged = page_out(needed); !paged) return paged;
    const std::size_t needed_bytes = bytes_with(band, wanted);
    tight_ += needed_bytes > budget / 8 * 7 ? 1 : 0;  // it is full again a few frames later
    if (needed_bytes > budget || tight_ > kMostTightFrames) {
      return Error{ErrorCode::kBudget, fmt::format("frame {} alone needs {} of the {} MiB that the volume may take",
                                                   volume_.frames + 1, needed_bytes >> 20, budget >> 20)};
    }
  }
  for (const Coord& region : wanted) {
    if (auto read = page_in(region); !read) return read;
  }
  const std::uint32_t frames = volume_.frames + 1 - full_since_;
  if (full_since_ > 0 && frames > kFramesBeforeGivingUp && read_again_ > kMostBlocksOfAFrame * frames) {
    return Error{ErrorCode::kBudget, "most frames need other parts of the volume than the frame before"};
  }
  return {};
}

std::size_t PagedVolume::bytes_with(std::span<const BandBlock> band, std::span<const Coord> pages) const {
  VolumeMemory memory = volume_.memory();
  RegionSet to_come(pages.begin(), pages.end());
  for (const Coord& region : pages) {
    const BlocksOfRegion& blocks = pages_.at(region).blocks;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i]) memory.add(block_of(region, i));
    }
  }
  for (const BandBlock& block : band) {
    const Coord region = region_of(block.origin);
    const bool is_on_page = to_come.contains(region) && pages_.at(region).blocks[number_in_region(block.origin)];
    if (!is_on_page && volume_.index().find(block.origin) == BlockIndex::kNone) memory.add(block.origin);
  }
  return memory.most_bytes();
}

Result<void> PagedVolume::page_in(const Coord& region) {
  const auto unreadable = [](Error error) {
    error.code = ErrorCode::kOutput;  // it was written a moment ago
    return error;
  };
  const auto file = BrickFile::open(path_of(region), kJob);
  if (!file) return unreadable(file.error());
  for (const BrickLayer& layer : file->layers()) {
    if (auto read = file->read(layer, volume_); !read) return unreadable(read.error());
  }
  Page& page = pages_.at(region);
  page.is_in_memory = true;
  read_again_ += page.blocks.count();
  return {};
}

Result<void> PagedVolume::page_out(const RegionSet& kept) {
  const auto blocks = std::as_const(volume_).index().blocks();
  for (const auto& region : volume_.index().regions()) {
    if (kept.contains(region->origin)) continue;
    Page& page = pages_[region->origin];
    page.is_in_memory = false;
    std::vector<const VolumeBlock*> of_region;
    for (const BlockIndex::Number number : region->blocks) of_region.push_back(&blocks[number]);
    if (std::none_of(of_region.begin(), of_region.end(), [](const auto* block) { return block->has_changed; }))
      continue;
    page.blocks.reset();
    for (const VolumeBlock* block : of_region) page.blocks.set(number_in_region(block->origin));
    page.to_carve = blocks_to_carve(*region, volume_);
    if (auto written = write_page(std::move(of_region), kJob, path_of(region->origin)); !written) return written;
  }
  volume_.keep_only(kept);
  return_freed_memory();
  return {};
}

Result<BrickVolume> PagedVolume::finish() {
  if (auto written = page_out({}); !written) return written.error();
  BrickVolume whole(volume_.config());
  for (const auto& [region, page] : pages_) {
    if (auto added = whole.add(path_of(region), kJob); !added) return added.error();
  }
  return whole;
}

std::filesystem::path PagedVolume::path_of(const Coord& region) const {
  const Coord at = region >> 6;
  return folder_ / fmt::format("{}_{}_{}.page", at.x(), at.y(), at.z());
}

}  // namespace scanknit
