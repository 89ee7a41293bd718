// The axis that points up, and a box along the axes.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace scanknit {

/// The axis of a world that points up; kMinusY: its y axis points down, as a camera's does.
enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

/// The box to which the user crops a scan. Axes of the world, metres; nothing: no crop.
using CropBox = std::optional<Eigen::AlignedBox3d>;

}  // namespace scanknit
