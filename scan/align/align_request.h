// The request for an alignment: which scans, and what the user knows of their poses.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace scanknit {

/// What the user knows of the scans' poses, in addition to the poses in their files.
struct KnownPlaces {
  std::optional<std::filesystem::path> initial = {};  ///< poses: lines of SCAN tx ty tz qx qy qz qw
  std::optional<std::filesystem::path> markers = {};  ///< lines of SCAN MARKER x y z
  bool wants_refinement = false;                      ///< true: refine the poses of the files
};

struct AlignRequest {
  std::vector<std::filesystem::path> inputs;  ///< range scans, recordings, meshes, point clouds, .conf
  KnownPlaces known;
  std::optional<std::filesystem::path> points = {};  ///< .ply or .pcd: the points of all scans, in one frame
  /// True: the voxel size of the job counts. False: range scans are fused in voxels as large as their points' spacing.
  bool has_voxel_size = true;
};

}  // namespace scanknit
