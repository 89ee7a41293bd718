// The values of each kind of volume, to find out how they are distributed.
#pragma once

#include <openvdb/openvdb.h>

#include "core/result.h"
#include "extract/volume/slice_reader.h"
#include "scan/volume/auto_isovalue.h"

namespace scanknit {

/// The active values; an active tile counts as one leaf.
[[nodiscard]] ValueSource values_of(const openvdb::FloatGrid& grid);
[[nodiscard]] ValueSource values_of(SliceReader& reader);
[[nodiscard]] ValueSource values_of(const DenseVolume& volume);

[[nodiscard]] Result<ValueCensus> take_census(const ValueSource& values);

/// "from -1024 to 3071". The census must have counted a value.
[[nodiscard]] std::string range_text(const ValueCensus& census);

}  // namespace scanknit
