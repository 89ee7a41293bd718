// BlockCounter: how many blocks frames will need.
#pragma once

#include <cstddef>
#include <unordered_set>

#include "core/frame.h"
#include "core/pose.h"
#include "fusion/fusion_config.h"
#include "fusion/volume/volume_memory.h"

namespace scanknit {

/// Counts the blocks that a set of frames needs, without allocating voxels, to refuse a volume before fusing it.
class BlockCounter {
 public:
  /// Stops counting beyond `max_bytes`.
  BlockCounter(const FusionConfig& config, std::size_t max_bytes);
  void add(const Frame& frame, const Pose& T_world_camera);
  [[nodiscard]] std::size_t blocks() const;
  /// Of the memory that these blocks may need.
  [[nodiscard]] std::size_t most_bytes() const { return memory_.most_bytes(); }
  [[nodiscard]] bool is_full() const { return most_bytes() > max_bytes_; }

 private:
  FusionConfig config_;
  std::size_t max_bytes_;
  std::unordered_set<openvdb::Coord> origins_;
  VolumeMemory memory_;
};

}  // namespace scanknit
