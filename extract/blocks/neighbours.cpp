#include "extract/blocks/neighbours.h"

#include <algorithm>

namespace scanknit {
namespace {

bool is_at(std::span<const Eigen::Vector3i> origins, std::size_t block, const Eigen::Vector3i& target) {
  return block < origins.size() && origins[block].z() == target.z() && origins[block].y() == target.y() &&
         origins[block].x() == target.x();
}

/// The first block that is not before `target`, which is likely to be near `guess`.
std::size_t find(std::span<const Eigen::Vector3i> origins, std::size_t guess, const Eigen::Vector3i& target) {
  constexpr std::size_t kNear = 4;
  std::size_t from = guess - std::min(guess, kNear);
  if (from > 0 && !is_before(origins[from - 1], target)) from = 0;
  const std::size_t to = std::min(from + 2 * kNear, origins.size());
  for (; from < to; ++from) {
    if (!is_before(origins[from], target)) return from;
  }
  const auto begin = origins.begin() + static_cast<std::ptrdiff_t>(from);
  return static_cast<std::size_t>(std::lower_bound(begin, origins.end(), target, is_before) - origins.begin());
}

}  // namespace

const Neighbours& NeighbourWalk::of(std::size_t block) {
  const bool is_step = is_next_of_run(block);
  block_ = block;
  if (is_step) {
    step();
  } else {
    jump(block);
  }
  return found_;
}

bool NeighbourWalk::is_next_of_run(std::size_t block) const {
  return block_ != kNoBlock && block == block_ + 1 &&
         is_at(origins_, block, origins_[block_] + Eigen::Vector3i(0, 0, kBlockCells));
}

void NeighbourWalk::jump(std::size_t block) {
  for (int run = 0; run < 9; ++run) {
    const Eigen::Vector3i offset(run / 3 - 1, run % 3 - 1, -1);
    Eigen::Vector3i target = origins_[block] + kBlockCells * offset;
    std::size_t& next = runs_[static_cast<std::size_t>(run)];
    next = find(origins_, next, target);
    for (int dz = 0; dz < 3; ++dz, target.z() += kBlockCells)
      found_.blocks_[static_cast<std::size_t>(3 * run + dz)] = is_at(origins_, next, target) ? next++ : kNoBlock;
  }
}

void NeighbourWalk::step() {
  for (int run = 0; run < 9; ++run) {
    const Eigen::Vector3i offset(run / 3 - 1, run % 3 - 1, 1);
    std::size_t& next = runs_[static_cast<std::size_t>(run)];
    std::size_t* const found = &found_.blocks_[static_cast<std::size_t>(3 * run)];
    found[0] = found[1];
    found[1] = found[2];
    found[2] = is_at(origins_, next, origins_[block_] + kBlockCells * offset) ? next++ : kNoBlock;
  }
}

}  // namespace scanknit
