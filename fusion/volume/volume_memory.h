// VolumeMemory: what the blocks of a volume take, counted as they come. BlockBudget: which more there is room for.
#pragma once

#include <openvdb/openvdb.h>

#include <atomic>
#include <cstddef>
#include <unordered_set>
#include <utility>

namespace scanknit {

/// Leaves, the inner nodes of the three trees above them, and entries in the index. Inner nodes are large, 0.8 MiB for
/// a cube of 4096^3 voxels, eight of which meet at the origin: a small scan needs as much for them as for its voxels.
class VolumeMemory {
 public:
  [[nodiscard]] std::size_t bytes() const;
  /// When every block has colours: a budget must have room for them.
  [[nodiscard]] std::size_t most_bytes() const;
  /// With one more block of 8^3 voxels.
  [[nodiscard]] std::size_t most_bytes_with(const openvdb::Coord& origin) const;
  /// The block at `origin` is not in it yet. Without colours.
  void add(const openvdb::Coord& origin);
  /// A block has colours now. May be called by several threads at once.
  void add_colours() { std::atomic_ref(coloured_).fetch_add(1, std::memory_order_relaxed); }

 private:
  std::size_t blocks_ = 0;
  std::size_t coloured_ = 0;
  std::unordered_set<openvdb::Coord> lower_nodes_, upper_nodes_;
};

/// Says for which new blocks there is room within a budget, and counts them as if each had colours.
class BlockBudget {
 public:
  /// `memory`: of the blocks that the volume has.
  BlockBudget(VolumeMemory memory, std::size_t max_bytes) : memory_(std::move(memory)), max_bytes_(max_bytes) {}

  /// True if there is room for one more block, at `origin`: it is counted from now on.
  [[nodiscard]] bool admits(const openvdb::Coord& origin);
  /// True once a block was not admitted. A block that needs fewer nodes of the trees may be, afterwards.
  [[nodiscard]] bool is_reached() const { return is_reached_; }

 private:
  VolumeMemory memory_;
  std::size_t max_bytes_;
  bool is_reached_ = false;
};

}  // namespace scanknit
