// LiveMesh: the mesh of a growing volume, in chunks for the live view.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "extract/incremental_mesher.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// Chunks are cubes of 4^3 leaves of 8^3 voxels: large enough for a browser to draw hundreds of thousands of triangles
/// in a few hundred pieces, small enough that little is sent again when one leaf changes.
class LiveMesh {
 public:
  /// `volume` outlives it and keeps its address. The chunks have higher revisions than `last_revision`. Errors: those
  /// of IncrementalMesher::create().
  [[nodiscard]] static Result<LiveMesh> create(const TsdfVolume& volume, const ExtractConfig& config,
                                               std::uint32_t last_revision = 0);

  /// Takes the chunk's number and its message (view/mesh_chunk.h).
  using Publish = std::function<void(std::uint32_t, std::string)>;

  /// Meshes at most `most_leaves` leaves of 8^3 voxels that have changed, and publishes the chunks that differ now.
  /// Order: leaves with matter that were never meshed, the latest first; then other leaves with matter, the one that
  /// has waited longest first; then leaves without matter. After an error the same leaves still wait.
  [[nodiscard]] Result<void> update(TsdfVolume& volume, std::size_t most_leaves, const Publish& publish);

  [[nodiscard]] std::size_t triangles() const { return triangles_; }
  [[nodiscard]] std::uint32_t revision() const {
    return last_revision_ + static_cast<std::uint32_t>(mesher_.revision());
  }

  /// True when a whole triangle lies within the box; world, metres.
  [[nodiscard]] bool has_triangle_in(const Eigen::AlignedBox3d& box) const;

  [[nodiscard]] bool is_up_to_date() const { return new_.empty() && changed_.empty() && free_.empty(); }

 private:
  struct Chunk {
    std::uint32_t number = 0;
    std::size_t triangles = 0;
  };

  LiveMesh(const TsdfVolume& volume, IncrementalMesher mesher, std::uint32_t last_revision);
  void note(const TsdfVolume& volume, const openvdb::Coord& leaf);
  [[nodiscard]] std::vector<BlockIndex::Number> take_some(const TsdfVolume& volume, std::size_t most_leaves);
  void take_chunk(const TsdfVolume& volume, BlockIndex::Number first, std::size_t most_leaves,
                  std::vector<BlockIndex::Number>& some);
  void queue_changed(BlockIndex::Number number);
  [[nodiscard]] std::string message_of(const TsdfVolume& volume, const Eigen::Vector3i& at, Chunk& chunk) const;

  IncrementalMesher mesher_;
  std::uint32_t last_revision_;  ///< revision of the mesh that was shown before
  double voxel_size_m_;
  enum class Waiting : std::uint8_t { kNot, kFree, kMatter };
  struct BlockState {
    Waiting waiting = Waiting::kNot;
    bool was_meshed = false;
    bool is_in_changed = false;
  };
  std::vector<BlockState> states_;          ///< for each block of the volume
  std::vector<BlockIndex::Number> new_;     ///< blocks waiting for the first time, in the order in which they came
  std::deque<BlockIndex::Number> changed_;  ///< blocks waiting again, likewise
  /// Blocks without matter that are waiting, likewise. The surface in their cells belongs to neighbours with matter and
  /// is meshed with these. A block that has got matter since then also waits in a list above, and is skipped here.
  std::deque<BlockIndex::Number> free_;
  std::map<Eigen::Vector3i, Chunk, BlockOrder> chunks_;  ///< keyed by the chunk's first voxel
  std::size_t triangles_ = 0;
};

}  // namespace scanknit
