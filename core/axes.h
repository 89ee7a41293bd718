// Axes: which way is up, and a box along them.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace scanknit {

/// The axis of a world that points up; kMinusY: its y axis points down, as a camera's does.
enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

/// What a person cut a scan to. Axes of the world, metres; nothing: no crop.
using CropBox = std::optional<Eigen::AlignedBox3d>;

}  // namespace scanknit
