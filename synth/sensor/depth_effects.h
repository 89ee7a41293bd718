// What happens to a picture of depth before it is measured: shadows, edges, corners. Each is a pure function, the same
// for any number of threads; depth 0 is "no surface".
#pragma once

#include <cstdint>

#include "core/image.h"

namespace scanknit {

/// 1 where a second centre, `baseline_m` to the right of the camera, does not see what the camera sees, 0 elsewhere.
/// Beside an object at depth z1 before a wall at z2 that is a strip of focal * baseline (1 / z1 - 1 / z2) pixels at the
/// object's left; below 0, the centre is at the left and the strip at the object's right. `focal_px` is the picture's.
[[nodiscard]] Image<std::uint8_t> occlusion_shadows(const DepthImage& depth_m, double focal_px, double baseline_m);

/// How a step of depth is told from a slanted surface, whose inverse depth is linear over the picture.
struct StepThreshold {
  double floor_m = 0.015;
  double share = 0.01;          ///< of depth
  double per_square_metre = 0;  ///< of depth squared: what a part of a disparity step is
};

/// 1 where one of the four pairs of opposite neighbours departs by a step, or has no depth; 0 elsewhere.
[[nodiscard]] Image<std::uint8_t> depth_steps(const DepthImage& depth_m, const StepThreshold& threshold);

/// 1 within `reach` pixels of a 1, in a square.
[[nodiscard]] Image<std::uint8_t> widened(const Image<std::uint8_t>& mask, int reach);

/// Concave corners, as light that bounces twice smears them: a pixel that lies deeper than the line between two
/// surface points `radius_m` to both sides of it comes `share` of the way to that line. Planes stay as they are.
[[nodiscard]] DepthImage smear_corners(const DepthImage& depth_m, double focal_px, double share, double radius_m);

}  // namespace scanknit
