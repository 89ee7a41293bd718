// VolumeMemory: what the blocks of a volume take, counted as they come.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <unordered_set>

namespace scanknit {

/// Leaves, the inner nodes of the three trees above them, and entries in the index. Inner nodes are large, 0.8 MiB for
/// a cube of 4096^3 voxels, eight of which meet at the origin: a small scan needs as much for them as for its voxels.
class VolumeMemory {
 public:
  [[nodiscard]] std::size_t bytes() const;
  /// With one more block of 8^3 voxels.
  [[nodiscard]] std::size_t bytes_with(const openvdb::Coord& origin) const;
  /// The block at `origin` is not in it yet.
  void add(const openvdb::Coord& origin);

 private:
  std::size_t blocks_ = 0;
  std::unordered_set<openvdb::Coord> lower_nodes_, upper_nodes_;
};

}  // namespace scanknit
