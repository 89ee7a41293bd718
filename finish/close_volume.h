// Closing a scan in its volume, so that the surface that is extracted has no holes.
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

// Both functions read a view of signed distances, metres, negative in matter. A sample was seen iff it is observed with
// at least `min_weight`. The view's region and colours are not read: samples beyond the region are known too, and
// `cut_m` says what is cut off.

struct CloseRequest {
  double min_weight = 0;        ///< samples observed with less weight were not seen
  double isovalue_m = 0;        ///< matter is below
  double band_voxels = 4;       ///< about how deep the known band is
  Eigen::AlignedBox3d surface;  ///< world, metres: what is to be closed lies within
  /// Matter is cut off where this is positive: a signed distance, metres. Null: nothing is cut.
  std::function<double(const Eigen::Vector3d& p_world)> cut_m;
  bool is_outside_free = true;  ///< false: what lies beyond the box may be anything; holes in sheets are then closed
  std::size_t memory_bytes = 0;
};

/// A volume in which every sample near the surface is known.
struct ClosedVolume {
  openvdb::FloatGrid::Ptr field;  ///< its active voxels are all that extraction needs
  VoxelBox box;
  std::vector<std::uint8_t> is_seen;  ///< voxels of the box that are as they were

  /// Of the cell from sample `low` to the next one along each axis: what is in it was there before.
  [[nodiscard]] bool is_seen_cell(const Eigen::Vector3i& low) const;
  [[nodiscard]] Eigen::Vector3d index_of(const Eigen::Vector3d& p_world) const;
};

/// Samples that were seen keep their value, hence every vertex between two of them keeps its place. The rest of the box
/// (the surface, the band and a rim) is filled by the smallest surface (smallest_surface.h). With `is_outside_free` the
/// extracted surface is closed. The same bits for any number of threads. Errors: kBudget where the box needs more than
/// `memory_bytes`; kConfig for voxels that are no cubes.
[[nodiscard]] Result<ClosedVolume> close_volume(const FieldView& view, const CloseRequest& request);

/// A copy of the volume in which samples with cut_m > 0 are unknown (inactive), and all others that were seen active.
/// It has the volume's transform.
[[nodiscard]] openvdb::FloatGrid::Ptr cut_open(const FieldView& view, double min_weight,
                                               const std::function<double(const Eigen::Vector3d& p_world)>& cut_m);

}  // namespace scanknit
