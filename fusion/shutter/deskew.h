// Takes the camera's motion out of a frame.
#pragma once

#include "core/frame.h"
#include "core/frame_timing.h"

namespace scanknit {

/// Makes the frame what a camera would have taken that reads all rows at once, at the time of the middle one (Forssén &
/// Ringaby 2010, "Rectifying rolling shutter video from hand-held devices"). For each pixel of depth, the surface seen
/// by the row that saw it, on that pixel's ray; normals turn with their rows. Colours are read where they were seen,
/// for the typical depth of the frame. `T_colour_depth` becomes that between the times of the two pictures. What moves
/// by at most half a pixel is left as it is. `frame` has normals, or none at all.
void deskew(const FrameMotion& motion, Frame& frame);

}  // namespace scanknit
