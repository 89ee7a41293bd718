// VolumeMemory: counts the memory of a volume's blocks. BlockBudget: decides which blocks may be added.
#pragma once

#include <openvdb/openvdb.h>

#include <atomic>
#include <cstddef>
#include <unordered_set>
#include <utility>

namespace scanknit {

/// Counts leaves, the inner nodes of the three trees above them, and entries in the index. Inner nodes are large: 0.8
/// MiB for a cube of 4096^3 voxels. Eight such cubes meet at the origin, so that a small scan needs as much memory for
/// them as for its voxels.
class VolumeMemory {
 public:
  [[nodiscard]] std::size_t bytes() const;
  /// The memory if every block had colours, for which a budget must have room.
  [[nodiscard]] std::size_t most_bytes() const;
  /// The same with one more block of 8^3 voxels.
  [[nodiscard]] std::size_t most_bytes_with(const openvdb::Coord& origin) const;
  /// Adds the block at `origin`, which was not counted yet, without colours.
  void add(const openvdb::Coord& origin);
  /// Adds the colours of a block. Several threads may call this at once.
  void add_colours() { std::atomic_ref(coloured_).fetch_add(1, std::memory_order_relaxed); }

 private:
  std::size_t blocks_ = 0;
  std::size_t coloured_ = 0;
  std::unordered_set<openvdb::Coord> lower_nodes_, upper_nodes_;
};

/// Decides which new blocks fit within a budget, and counts each as if it had colours.
class BlockBudget {
 public:
  /// `memory`: of the volume's blocks.
  BlockBudget(VolumeMemory memory, std::size_t max_bytes) : memory_(std::move(memory)), max_bytes_(max_bytes) {}

  /// True if there is room for one more block, at `origin`; then counts it.
  [[nodiscard]] bool admits(const openvdb::Coord& origin);
  /// True after a block was not admitted. A later block that needs fewer tree nodes may still be admitted.
  [[nodiscard]] bool is_reached() const { return is_reached_; }

 private:
  VolumeMemory memory_;
  std::size_t max_bytes_;
  bool is_reached_ = false;
};

}  // namespace scanknit
