// FieldView: a fused or loaded volume, for reading. The only header of core that uses OpenVDB: it is not part of core's
// library, and a target that includes it must link OpenVDB (fusion, extract and finish do).
#pragma once

#include <openvdb/openvdb.h>

#include <optional>

#include "core/voxel_codes.h"

namespace scanknit {

/// The grids of a live volume (core/voxel_codes.h).
using WeightCodeGrid = openvdb::Grid<openvdb::tree::Tree4<WeightCode, 5, 4, 3>::Type>;
using ColourCodeGrid = openvdb::Grid<openvdb::tree::Tree4<ColourCode, 5, 4, 3>::Type>;

/// Grids with the same transform (uniform scale and translation) and topology, except those that are null; they belong
/// to the volume, which must outlive the view. A sample sits AT index (i, j, k). Voxels outside the field's leaves and
/// active tiles are unobserved, and so are samples that are not finite. Made by TsdfVolume::field_view() and
/// LoadedVolume::field_view().
struct FieldView {
  /// Never null. Signed distance in metres, positive in free space; or any other quantity.
  const openvdb::FloatGrid* field = nullptr;
  /// A voxel is observed if its weight is > 0 and at least the reader's minimum weight (for example
  /// ExtractConfig::min_weight). Null: every active voxel is observed.
  const openvdb::FloatGrid* weight = nullptr;
  /// sRGB-encoded, 0 to 1; a negative component: no colour was seen. Null: no colours.
  const openvdb::Vec3SGrid* colour = nullptr;
  /// The weights and colours of a live volume, as codes; set instead of `weight` and `colour`.
  const WeightCodeGrid* weight_codes = nullptr;
  const ColourCodeGrid* colour_codes = nullptr;
  /// Samples outside of it are unobserved.
  std::optional<openvdb::CoordBBox> region = std::nullopt;
  /// True: InsideSide::kAuto takes the side below the isovalue as matter; false: the side above.
  bool is_signed_distance = true;

  /// The same view with another field, whose active voxels are all observed. `other` must outlive the view.
  [[nodiscard]] FieldView with_field(const openvdb::FloatGrid& other) const {
    FieldView view = *this;
    view.field = &other;
    view.weight = nullptr;
    view.weight_codes = nullptr;
    return view;
  }
  [[nodiscard]] FieldView without_colours() const {
    FieldView view = *this;
    view.colour = nullptr;
    view.colour_codes = nullptr;
    return view;
  }
};

}  // namespace scanknit
