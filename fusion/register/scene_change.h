// Tells something that came, went or moved from what the errors of a sensor and of its pose do to a picture.
#pragma once

#include "core/frame_timing.h"
#include "core/noise_model.h"
#include "core/pose.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// The share, of the frame's points before which the model has a surface, that belongs to patches in which the frame is
/// nearer than the model, or farther, by more than the noise. A pose or a calibration that is a little wrong
/// contradicts the model as well, but in strips along the edges of things: only what a square of a thirtieth of the
/// picture's width fits into counts (an opening: Serra 1982, "Image Analysis and Mathematical Morphology"). `rows`: the
/// camera's motion while the frame's rows are read.
[[nodiscard]] double changed_share(const SurfaceLevel& frame, const SurfaceLevel& model, const Pose& T_model_frame,
                                   const SteadyMotion& rows, const NoiseModel& noise);

}  // namespace scanknit
