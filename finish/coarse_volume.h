// CoarseVolume: a volume of larger voxels, where the whole is too large for a step.
#pragma once

#include <openvdb/openvdb.h>

#include <optional>

#include "core/field_view.h"

namespace scanknit {

/// One voxel for each cube of `step` voxels along an edge: the mean of its samples that were seen
/// (finish/seen_leaves.h), in the middle of the cube, if a quarter of them were. The mean keeps noise from making
/// handles that larger voxels would give no triangles to.
class CoarseVolume {
 public:
  /// Takes its transform, kind of values and region from `like`, of cubic voxels, which need not outlive it. `step` >
  /// 0.
  CoarseVolume(const FieldView& like, int step);

  /// Adds a part of the volume; each part once. The bits depend on the order of parts whose cubes overlap.
  void add(const FieldView& part, double min_weight);

  /// After the last part: all that was added. Every active voxel was observed. To be called once.
  [[nodiscard]] FieldView finish();

 private:
  int step_;
  bool is_signed_distance_;
  std::optional<openvdb::CoordBBox> region_;
  openvdb::FloatGrid::Ptr field_;     ///< until finish(): the sums
  openvdb::FloatGrid::Ptr seen_;      ///< until finish(): how many samples
  openvdb::Vec3SGrid::Ptr colour_;    ///< null: no colours
  ColourCodeGrid::Ptr colour_codes_;  ///< likewise
};

}  // namespace scanknit
