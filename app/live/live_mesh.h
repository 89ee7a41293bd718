// LiveMesh: the mesh of a volume while it is fused, in chunks for the live view.
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
  /// `volume` outlives it and stays where it is. Its chunks have higher revisions than `last_revision`. Errors: those
  /// of IncrementalMesher::create().
  [[nodiscard]] static Result<LiveMesh> create(const TsdfVolume& volume, const ExtractConfig& config,
                                               std::uint32_t last_revision = 0);

  /// Takes the chunk's number and its message (view/mesh_chunk.h).
  using Publish = std::function<void(std::uint32_t, std::string)>;

  /// Meshes some of what changed since it was meshed last (at most `most_leaves` leaves of 8^3 voxels: first those with
  /// matter that never were meshed, the latest first, then others with matter, the one that waited longest first, then
  /// those without) and publishes the chunks that are different now. After an error the same leaves still wait.
  [[nodiscard]] Result<void> update(TsdfVolume& volume, std::size_t most_leaves, const Publish& publish);

  [[nodiscard]] std::size_t triangles() const { return triangles_; }
  [[nodiscard]] std::uint32_t revision() const {
    return last_revision_ + static_cast<std::uint32_t>(mesher_.revision());
  }

  /// Whether a triangle of it lies within the box; world, metres.
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
  std::uint32_t last_revision_;  ///< of a mesh that was shown before
  double voxel_size_m_;
  enum class Waiting : std::uint8_t { kNot, kFree, kMatter };
  struct BlockState {
    Waiting waiting = Waiting::kNot;
    bool was_meshed = false;
    bool is_in_changed = false;
  };
  std::vector<BlockState> states_;          ///< of each block of the volume
  std::vector<BlockIndex::Number> new_;     ///< waiting for the first time, in the order in which they came
  std::deque<BlockIndex::Number> changed_;  ///< waiting again, likewise
  /// Waiting, likewise, without any matter: what surface is in their cells belongs to neighbours with matter, and is
  /// meshed with these. Those that have got matter since wait above as well, and are passed over here.
  std::deque<BlockIndex::Number> free_;
  std::map<Eigen::Vector3i, Chunk, BlockOrder> chunks_;  ///< by the chunk's first voxel
  std::size_t triangles_ = 0;
};

}  // namespace scanknit
