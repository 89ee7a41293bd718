// What `align` is asked for.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace scanknit {

/// What is known of where the scans are, beside what their files say.
struct KnownPlaces {
  std::optional<std::filesystem::path> initial = {};  ///< poses: lines of SCAN tx ty tz qx qy qz qw
  std::optional<std::filesystem::path> markers = {};  ///< lines of SCAN MARKER x y z
  bool wants_refinement = false;                      ///< poses that the files carry are a beginning, not the end
};

struct AlignRequest {
  std::vector<std::filesystem::path> inputs;  ///< range scans, recordings, meshes, point clouds, .conf
  KnownPlaces known;
  std::optional<std::filesystem::path> points = {};  ///< .ply or .pcd: all points, each scan in its place
  /// True: the voxel size of the job counts. False: range scans are fused in voxels as large as their points' spacing.
  bool has_voxel_size = true;
};

}  // namespace scanknit
