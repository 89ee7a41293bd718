// align_and_mesh: several scans of one thing, brought together and meshed as one.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// What is known of where the scans are, beside what their files say.
struct KnownPlaces {
  std::optional<std::filesystem::path> initial = {};  ///< poses: lines of SCAN tx ty tz qx qy qz qw
  std::optional<std::filesystem::path> markers = {};  ///< lines of SCAN MARKER x y z
  bool wants_refinement = false;                      ///< poses that the files carry are a beginning, not the end
};

/// What is to be aligned.
struct AlignRequest {
  std::vector<std::filesystem::path> inputs;  ///< range scans, recordings, meshes, point clouds, .conf
  KnownPlaces known;
  std::optional<std::filesystem::path> points = {};  ///< .ply or .pcd: all points, each scan in its place
  /// True: the voxel size of the job counts. False: range scans are fused in voxels as large as their points' spacing.
  bool has_voxel_size = true;
};

/// Reads all inputs, finds the place of each, and fuses range scans and recordings into one mesh. Meshes and point
/// clouds are brought to their places only. ScanResult::outcome: kOutput before any work; kInput; kTooLittle when a
/// scan has no place beside the first, or it was stopped; kMesh.
[[nodiscard]] ScanResult align_and_mesh(const ScanJob& job, const AlignRequest& request, ScanObserver& observer,
                                        std::stop_token stop = {});

}  // namespace scanknit
