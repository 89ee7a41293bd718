// A lens and poses to begin with.
#pragma once

#include <vector>

#include "calibrate/lens/bundle.h"

namespace scanknit {

/// The focal length by the homographies of the views (Zhang 2000, "A flexible new technique for camera calibration",
/// equations 3 and 4), with square pixels and the centre in the middle of the picture; the picture's width if they do
/// not tell it: boards that all face the camera. No distortion.
[[nodiscard]] LensVector guess_lens(const std::vector<BundleView>& views, int width, int height);

/// T_camera_board by the homography between the board and the straightened picture (Zhang 2000, section 3.1), then by
/// least squares.
[[nodiscard]] Pose guess_pose(const LensVector& lens, const BundleView& view);

}  // namespace scanknit
