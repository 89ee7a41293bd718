// Finds the shift between two pictures: a start for registration after a quick turn.
#pragma once

#include "core/pose.h"
#include "fusion/register/surface_pyramid.h"

namespace scanknit {

/// The rotation of the camera, as T_model_frame, with which the frame's depth and intensity are most similar to the
/// model's: from the best shift of the picture, up to a seventh of its size, at the coarsest level. Identity if no
/// shift is better than none.
[[nodiscard]] Pose turn_by_shift(const SurfacePyramid& frame, const SurfacePyramid& model);

}  // namespace scanknit
