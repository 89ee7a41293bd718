// VolumeMemory: what the blocks of a volume take, counted as they come.
#pragma once

#include <openvdb/openvdb.h>

#include <atomic>
#include <cstddef>
#include <unordered_set>

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

}  // namespace scanknit
