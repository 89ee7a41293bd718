// LiveMesh: the mesh of a volume while it is fused, in chunks for the live view.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/result.h"
#include "extract/incremental_mesher.h"
#include "fusion/tsdf_volume.h"

namespace scanknit {

/// Chunks are cubes of 4^3 leaves of 8^3 voxels: large enough for a browser to draw hundreds of thousands of triangles
/// in a few hundred pieces, small enough that little is sent again when one leaf changes.
class LiveMesh {
 public:
  /// `volume` outlives it and stays where it is. Errors: those of IncrementalMesher::create().
  [[nodiscard]] static Result<LiveMesh> create(const TsdfVolume& volume, const ExtractConfig& config);

  /// Takes the chunk's number and its message (view/mesh_chunk.h).
  using Publish = std::function<void(std::uint32_t, std::string)>;

  /// Meshes some of what changed since it was meshed last (at most `most_leaves` leaves of 8^3 voxels: first those that
  /// never were meshed, the latest first, then in the order in which they lie, going on from where the last call ended)
  /// and publishes the chunks that are different now.
  [[nodiscard]] Result<void> update(TsdfVolume& volume, std::size_t most_leaves, const Publish& publish);

  [[nodiscard]] std::size_t triangles() const { return triangles_; }
  [[nodiscard]] bool is_up_to_date() const { return new_.empty() && changed_.empty(); }

 private:
  struct Chunk {
    std::uint32_t number = 0;
    std::size_t triangles = 0;
  };

  using Leaves = std::set<Eigen::Vector3i, BlockOrder>;

  LiveMesh(const TsdfVolume& volume, IncrementalMesher mesher);
  void note(const openvdb::Coord& leaf);
  [[nodiscard]] std::vector<Eigen::Vector3i> some_of_what_changed(std::size_t most_leaves) const;
  [[nodiscard]] std::string message_of(const TsdfVolume& volume, const Eigen::Vector3i& at, Chunk& chunk) const;

  IncrementalMesher mesher_;
  Leaves seen_;                       ///< that were ever to be meshed
  std::vector<Eigen::Vector3i> new_;  ///< that are to be meshed for the first time, in the order in which they came
  Leaves changed_;                    ///< that are to be meshed again, or were changed before their first time
  Eigen::Vector3i last_ = Eigen::Vector3i::Zero();       ///< of the leaves that were meshed again, the last
  std::map<Eigen::Vector3i, Chunk, BlockOrder> chunks_;  ///< by the chunk's first voxel
  std::size_t triangles_ = 0;
};

}  // namespace scanknit
