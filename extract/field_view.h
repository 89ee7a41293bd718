// FieldView: all that extraction needs to know of a volume.
#pragma once

#include <openvdb/openvdb.h>

namespace scanknit {

/// Grids of one transform (uniform scale and translation) and, where given, one topology. A sample sits AT index (i, j,
/// k).
struct FieldView {
  const openvdb::FloatGrid* field = nullptr;  ///< never null. Signed distance in metres, positive in free space
  const openvdb::FloatGrid* weight =
      nullptr;  ///< observed iff weight > 0 and >= min_weight; null: every active voxel is
  const openvdb::Vec3SGrid* colour =
      nullptr;                     ///< sRGB-encoded, 0 to 1; a negative component: no colour was seen; null: none
  bool is_signed_distance = true;  ///< what InsideSide::kAuto goes by: matter is Low
};

}  // namespace scanknit
