// Intrinsics from a field of view: OpenNI reports nothing more.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "core/camera.h"

namespace scanknit {

/// The pinhole camera with these fields of view from edge to edge (radians, above 0 and below pi) and its principal
/// point in the middle. Nothing for other angles.
[[nodiscard]] inline std::optional<CameraIntrinsics> intrinsics_of_view(int width, int height, double x_rad,
                                                                        double y_rad) {
  const auto is_view = [](double angle) { return angle > 0 && angle < std::numbers::pi; };
  if (!is_view(x_rad) || !is_view(y_rad)) return std::nullopt;
  return CameraIntrinsics{width,
                          height,
                          width / (2 * std::tan(x_rad / 2)),
                          height / (2 * std::tan(y_rad / 2)),
                          (width - 1) / 2.0,
                          (height - 1) / 2.0};
}

}  // namespace scanknit
