// How far a picture has moved: a start for registration after a quick turn.
#pragma once

#include "core/pose.h"
#include "fusion/track/surface_pyramid.h"

namespace scanknit {

/// The turn of the camera, as T_model_frame, by which the frame's depth and intensity look most like the model's: the
/// best shift of the picture up to a seventh of its size, at the coarsest level. Identity when no shift is better than
/// none.
[[nodiscard]] Pose turn_by_shift(const SurfacePyramid& frame, const SurfacePyramid& model);

}  // namespace scanknit
