// CropBox: the box to which the user crops a scan.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace scanknit {

/// Axes of the world, metres; nothing: no crop.
using CropBox = std::optional<Eigen::AlignedBox3d>;

}  // namespace scanknit
