// Neighbours: the 26 blocks round a block.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "extract/blocks/block.h"

namespace scanknit {

inline constexpr std::size_t kNoBlock = static_cast<std::size_t>(-1);

/// Indices into the list of blocks, or kNoBlock; the block itself in the middle.
class Neighbours {
 public:
  /// Each offset -1, 0 or +1.
  [[nodiscard]] std::size_t at(int dx, int dy, int dz) const { return blocks_[place(dx, dy, dz)]; }
  [[nodiscard]] std::span<const std::size_t, 27> all() const { return blocks_; }

 private:
  friend class NeighbourWalk;
  [[nodiscard]] static std::size_t place(int dx, int dy, int dz) {
    return static_cast<std::size_t>(9 * (dx + 1) + 3 * (dy + 1) + (dz + 1));
  }
  std::array<std::size_t, 27> blocks_{};
};

/// Finds neighbours in a sorted list. Blocks that differ only in z follow one another in the list. A block and its
/// neighbours are in nine such runs, and a step to the next block in its run is a step in each of the nine.
class NeighbourWalk {
 public:
  /// `origins` sorted by is_before; it must outlive the walk.
  explicit NeighbourWalk(std::span<const Eigen::Vector3i> origins) : origins_(origins) {}

  /// Fast for blocks in ascending order, fastest for all of them in turn. The result is valid until the next call.
  [[nodiscard]] const Neighbours& of(std::size_t block);

 private:
  void jump(std::size_t block);
  void step();
  [[nodiscard]] bool is_next_of_run(std::size_t block) const;

  std::span<const Eigen::Vector3i> origins_;
  std::size_t block_ = kNoBlock;
  Neighbours found_;
  std::array<std::size_t, 9> runs_{};  ///< the next block of each run
};

}  // namespace scanknit
