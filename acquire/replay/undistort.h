// Undistortion: what a lens bent is straightened once, when a frame is read.
#pragma once

#include "acquire/acquire_config.h"
#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

/// Where the ideal pixel (u, v) of `camera` lies in the distorted picture: D. C. Brown 1966 / J. G. Fryer and D. C.
/// Brown 1986, in OpenCV's order of coefficients.
[[nodiscard]] Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                                            const Distortion& distortion);

/// The picture that the same camera without distortion would have seen; `camera` has its size. Depth takes the nearest
/// pixel, since the mean of two depths is a place where nothing is; outside the picture is 0.
[[nodiscard]] DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera,
                                   const Distortion& distortion);

/// Colour is interpolated bilinearly; outside the picture is black.
[[nodiscard]] ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera,
                                    const Distortion& distortion);

}  // namespace scanknit
