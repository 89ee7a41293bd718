#include "extract/neighbours.h"

#include <algorithm>

namespace scanknit {
namespace {

bool is_at(std::span<const Eigen::Vector3i> origins, std::size_t block, const Eigen::Vector3i& target) {
  return block < origins.size() && origins[block].z() == target.z() && origins[block].y() == target.y() &&
         origins[block].x() == target.x();
}

/// The first block that is not before `target`; `from` is that of an earlier target.
std::size_t advance(std::span<const Eigen::Vector3i> origins, std::size_t from, const Eigen::Vector3i& target) {
  if (is_at(origins, from + 1, target)) return from + 1;  // the usual step
  if (is_at(origins, from, target)) return from;
  if (from > 0 && !is_before(origins[from - 1], target)) from = 0;  // the walk went back
  constexpr std::size_t kSteps = 4;
  for (std::size_t i = from; i < std::min(from + kSteps, origins.size()); ++i) {
    if (!is_before(origins[i], target)) return i;
  }
  const auto begin = origins.begin() + static_cast<std::ptrdiff_t>(std::min(from + kSteps, origins.size()));
  return static_cast<std::size_t>(std::lower_bound(begin, origins.end(), target, is_before) - origins.begin());
}

}  // namespace

Neighbours NeighbourWalk::of(std::size_t block) {
  Neighbours found;
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      std::size_t& run = runs_[static_cast<std::size_t>(3 * (dx + 1) + dy + 1)];
      const Eigen::Vector3i first = origins_[block] + kBlockCells * Eigen::Vector3i(dx, dy, -1);
      run = advance(origins_, run, first);
      std::size_t next = run;
      for (int dz = -1; dz <= 1; ++dz) {
        const bool is_there = is_at(origins_, next, first + kBlockCells * Eigen::Vector3i(0, 0, dz + 1));
        found.blocks_[Neighbours::place(dx, dy, dz)] = is_there ? next++ : kNoBlock;
      }
    }
  }
  return found;
}

}  // namespace scanknit
