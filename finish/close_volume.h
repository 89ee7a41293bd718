// Closes a scan in its volume, so that the extracted surface has no holes.
#pragma once

#include <openvdb/openvdb.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/field_view.h"
#include "core/result.h"
#include "finish/voxel_box.h"

namespace scanknit {

// Both functions read a view of signed distances, metres, negative in matter. A sample counts as seen if it was
// observed with at least `min_weight`. They ignore the view's region and colours: samples outside of the region are
// used too, and `cut_m` cuts them off.

struct CloseRequest {
  double min_weight = 0;        ///< samples observed with less weight do not count as seen
  double isovalue_m = 0;        ///< matter is below it
  double band_voxels = 4;       ///< approximate half-width of the band of known samples
  Eigen::AlignedBox3d surface;  ///< world, metres: the bounds of the surface to close
  /// Matter is cut off where this is positive: a signed distance, metres. Null: nothing is cut.
  std::function<double(const Eigen::Vector3d& p_world)> cut_m;
  bool is_outside_free = true;  ///< false: beyond the box may be matter or free space; closes the holes in sheets
  std::size_t memory_bytes = 0;
};

/// A volume with a known sample everywhere near the surface.
struct ClosedVolume {
  openvdb::FloatGrid::Ptr field;  ///< its active voxels are those that extraction needs
  VoxelBox box;
  std::vector<std::uint8_t> is_seen;  ///< voxels of the box that keep their observed value

  /// True when all corners of the cell from sample `low` to the next one along each axis were seen.
  [[nodiscard]] bool is_seen_cell(const Eigen::Vector3i& low) const;
  [[nodiscard]] Eigen::Vector3d index_of(const Eigen::Vector3d& p_world) const;
};

/// Samples that were seen keep their value, so that every vertex between two of them keeps its position. The smallest
/// surface (smallest_surface.h) fills the rest of the box (the surface, the band and a rim). With `is_outside_free` the
/// extracted surface is closed. The same bits for any number of threads. Errors: kBudget when it needs more than
/// `memory_bytes` beside the volume, 14 to 30 for each voxel of the box (fill_by_smallest_surface()); kConfig for
/// voxels that are not cubes.
[[nodiscard]] Result<ClosedVolume> close_volume(const FieldView& view, const CloseRequest& request);

/// A copy of the volume with the same transform. Samples that were seen and have cut_m <= 0 are active, all others are
/// inactive (unknown).
[[nodiscard]] openvdb::FloatGrid::Ptr cut_open(const FieldView& view, double min_weight,
                                               const std::function<double(const Eigen::Vector3d& p_world)>& cut_m);

}  // namespace scanknit
