#include "fusion/bricks/brick_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "fusion/volume/volume_memory.h"

namespace scanknit {
namespace {

using openvdb::Coord;
using Region = BrickPlan::Region;

/// A part that grows region by region.
struct GrowingPart {
  std::vector<const Region*> regions;
  VolumeMemory memory;

  [[nodiscard]] BrickPart part() const {
    BrickPart part;
    std::vector<FrameRun> runs;
    for (const Region* region : regions) {
      part.regions.insert(region->origin);
      runs.insert(runs.end(), region->frames.begin(), region->frames.end());
    }
    part.frames = joined_runs(std::move(runs));
    part.most_bytes = memory.most_bytes();
    return part;
  }
};

VolumeMemory with_region(VolumeMemory memory, const Region& region) {
  region.for_each_block([&](const Coord& origin) { memory.add(origin); });
  return memory;
}

Coord brick_of(const Coord& region, int brick_voxels) {
  const auto along = [&](int axis) {
    const int down = region[axis] % brick_voxels;
    return region[axis] - (down < 0 ? down + brick_voxels : down);
  };
  return {along(0), along(1), along(2)};
}

Error too_large(int brick_voxels, std::size_t bytes, std::size_t max_bytes) {
  return {ErrorCode::kBudget, "a brick of " + std::to_string(brick_voxels) + " voxels may need " +
                                  std::to_string((bytes >> 20) + 1) + " MiB, more than fusion.memory_budget (" +
                                  std::to_string(max_bytes >> 20) + " MiB); set fusion.bricks=auto, or a smaller size"};
}

}  // namespace

Result<std::vector<BrickPart>> parts_of_bricks(const BrickPlan& plan, int brick_voxels, std::size_t max_bytes) {
  std::map<Coord, GrowingPart> bricks;
  for (const Region& region : plan.regions()) {
    GrowingPart& brick = bricks[brick_of(region.origin, brick_voxels)];
    brick.regions.push_back(&region);
    region.for_each_block([&](const Coord& origin) { brick.memory.add(origin); });
  }
  std::vector<BrickPart> parts;
  for (const auto& [origin, brick] : bricks) {
    const std::size_t bytes = brick.memory.most_bytes();
    if (bytes > max_bytes) return too_large(brick_voxels, bytes, max_bytes);
    parts.push_back(brick.part());
  }
  return parts;
}

std::vector<BrickPart> parts_within(const BrickPlan& plan, std::size_t max_bytes) {
  std::vector<BrickPart> parts;
  GrowingPart growing;
  for (const Region& region : plan.regions()) {
    VolumeMemory grown = with_region(growing.memory, region);
    if (grown.most_bytes() > max_bytes && !growing.regions.empty()) {
      parts.push_back(growing.part());
      growing = {};
      grown = with_region({}, region);
    }
    growing.regions.push_back(&region);
    growing.memory = std::move(grown);
  }
  if (!growing.regions.empty()) parts.push_back(growing.part());
  return parts;
}

std::vector<FrameRun> joined_runs(std::vector<FrameRun> runs) {
  std::sort(runs.begin(), runs.end(), [](const FrameRun& a, const FrameRun& b) { return a.first < b.first; });
  std::vector<FrameRun> all;
  for (const FrameRun& run : runs) {
    if (!all.empty() && run.first <= all.back().last + 1) {
      all.back().last = std::max(all.back().last, run.last);
    } else {
      all.push_back(run);
    }
  }
  return all;
}

std::size_t count_frames(const std::vector<FrameRun>& runs) {
  std::size_t frames = 0;
  for (const FrameRun& run : runs) frames += std::size_t{run.last} - run.first + 1;
  return frames;
}

}  // namespace scanknit
