// Tells from two pictures whether the camera has stood still between them.
#pragma once

#include "core/noise_model.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// True when most of the picture is as it was: the depth of most tiles has the same mean within the noise, and by the
/// intensity (Lucas & Kanade 1981) most tiles with a pattern have not moved by more than a sixteenth of a pixel. What
/// moves before the camera may fill a third of the picture, and brightness may change. False where the pictures
/// cannot tell: without colour, or with too few patterns. Both levels are of the same camera.
[[nodiscard]] bool stands_still(const SurfaceLevel& now, const SurfaceLevel& before, const NoiseModel& noise);

}  // namespace scanknit
