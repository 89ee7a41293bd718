// FieldView: all that extraction needs to know of a volume.
#pragma once

#include <openvdb/openvdb.h>

#include <optional>

#include "core/voxel_codes.h"

namespace scanknit {

using WeightCodeGrid = openvdb::Grid<openvdb::tree::Tree4<WeightCode, 5, 4, 3>::Type>;
using ColourCodeGrid = openvdb::Grid<openvdb::tree::Tree4<ColourCode, 5, 4, 3>::Type>;

/// Grids of one transform (uniform scale and translation) and, where given, one topology. A sample sits AT index
/// (i, j, k). Voxels outside the field's leaves and active tiles are unobserved, and so are samples that are not
/// finite.
struct FieldView {
  /// Never null. Signed distance in metres, positive in free space; or any other quantity.
  const openvdb::FloatGrid* field = nullptr;
  /// A voxel is observed iff its weight is > 0 and >= ExtractConfig::min_weight. Null: every active voxel is.
  const openvdb::FloatGrid* weight = nullptr;
  /// sRGB-encoded, 0 to 1; a negative component: no colour was seen. Null: no colours.
  const openvdb::Vec3SGrid* colour = nullptr;
  /// The same of a live volume, as codes; given instead of `weight` and `colour`.
  const WeightCodeGrid* weight_codes = nullptr;
  const ColourCodeGrid* colour_codes = nullptr;
  /// Samples outside of it are unobserved.
  std::optional<openvdb::CoordBBox> region = std::nullopt;
  /// What InsideSide::kAuto goes by: matter is Low.
  bool is_signed_distance = true;
};

}  // namespace scanknit
