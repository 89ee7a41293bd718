// align_and_mesh: registers several scans of one object and makes one mesh of them.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// What the user knows of the scans' poses, in addition to the poses in their files.
struct KnownPlaces {
  std::optional<std::filesystem::path> initial = {};  ///< poses: lines of SCAN tx ty tz qx qy qz qw
  std::optional<std::filesystem::path> markers = {};  ///< lines of SCAN MARKER x y z
  bool wants_refinement = false;                      ///< true: refine the poses of the files
};

/// What is to be aligned.
struct AlignRequest {
  std::vector<std::filesystem::path> inputs;  ///< range scans, recordings, meshes, point clouds, .conf
  KnownPlaces known;
  std::optional<std::filesystem::path> points = {};  ///< .ply or .pcd: the points of all scans, in one frame
  /// True: the voxel size of the job counts. False: range scans are fused in voxels as large as their points' spacing.
  bool has_voxel_size = true;
};

/// Reads all inputs, finds the pose of each, and fuses range scans and recordings into one mesh. Meshes and point
/// clouds only get a pose; they are not fused. ScanResult::outcome: kOutput before any work; kInput; kTooLittle when no
/// pose was found for a scan, or when the alignment was stopped; kMesh.
[[nodiscard]] ScanResult align_and_mesh(const ScanJob& job, const AlignRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
