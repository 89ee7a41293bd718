// The grids of an OpenVDB file that load_volume does not use.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fusion/volume/tsdf_volume.h"

namespace scanknit {

/// The names of the FloatGrids in the file that are neither `volume`'s field nor its weight, in the file's order; none
/// when the file cannot be read. Does not read the values.
[[nodiscard]] std::vector<std::string> other_float_grids(const std::filesystem::path& path, const LoadedVolume& volume);

}  // namespace scanknit
