// TsdfVolume: the live volume, OpenVDB grids of one transform and one topology.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <filesystem>

#include "core/result.h"
#include "fusion/fusion_config.h"

namespace scanknit {

/// Three grids named "tsdf", "weight", "colour", a sample AT index (i, j, k), world = voxel_size * index, allocated in
/// leaves of 8^3 voxels. Per voxel:
///   weight  sum of the observations' weights; 0 = unknown (never seen), > 0 = observed
///   tsdf    mean signed distance, metres, positive in free space; background +truncation
///   colour  mean sRGB-encoded colour, 0 to 1; negative = no colour was seen
/// A voxel is active iff its weight is > 0. Free space is weight > 0 with tsdf at +truncation.
class TsdfVolume {
 public:
  /// Errors (kConfig): a voxel size, truncation or budget that is not positive and finite.
  [[nodiscard]] static Result<TsdfVolume> create(const FusionConfig& config);

  [[nodiscard]] const FusionConfig& config() const { return config_; }
  [[nodiscard]] const openvdb::FloatGrid& tsdf() const { return *tsdf_; }
  [[nodiscard]] const openvdb::FloatGrid& weight() const { return *weight_; }
  [[nodiscard]] const openvdb::Vec3SGrid& colour() const { return *colour_; }
  [[nodiscard]] openvdb::FloatGrid& tsdf() { return *tsdf_; }
  [[nodiscard]] openvdb::FloatGrid& weight() { return *weight_; }
  [[nodiscard]] openvdb::Vec3SGrid& colour() { return *colour_; }

  [[nodiscard]] std::size_t blocks() const;         ///< leaves of 8^3 voxels
  [[nodiscard]] std::size_t active_voxels() const;  ///< observed voxels
  [[nodiscard]] double memory_mib() const;          ///< of the three grids
  /// Memory of one block of 8^3 voxels, its share of the tree included.
  [[nodiscard]] static std::size_t bytes_per_block();
  /// Blocks that fit the memory budget.
  [[nodiscard]] std::size_t max_blocks() const;

  /// True once integrate() had to leave out blocks because of the budget.
  bool is_budget_reached = false;

  /// Writes the three grids, all or nothing; stock grid types that any OpenVDB program opens. Errors: kOutput.
  [[nodiscard]] Result<void> save(const std::filesystem::path& path) const;

 private:
  TsdfVolume() = default;
  FusionConfig config_;
  openvdb::FloatGrid::Ptr tsdf_;
  openvdb::FloatGrid::Ptr weight_;
  openvdb::Vec3SGrid::Ptr colour_;
};

/// A volume read from a .vdb: ours, or any file with a FloatGrid.
struct LoadedVolume {
  openvdb::FloatGrid::Ptr field;    ///< "tsdf" if there is one, else the only (or first) FloatGrid
  openvdb::FloatGrid::Ptr weight;   ///< "weight" or null
  openvdb::Vec3SGrid::Ptr colour;   ///< "colour" or null
  bool is_signed_distance = false;  ///< ours, or of grid class level set
};

/// Errors (kInput): not there, not a VDB file, damaged, no FloatGrid in it (the message lists the grids that are).
[[nodiscard]] Result<LoadedVolume> load_volume(const std::filesystem::path& path);

}  // namespace scanknit
