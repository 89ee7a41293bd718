// Removes lens distortion once, when a frame is read.
#pragma once

#include "acquire/acquire_config.h"
#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

/// The position of the ideal pixel (u, v) of `camera` in the distorted picture: D. C. Brown 1966 / J. G. Fryer and D.
/// C. Brown 1986, in OpenCV's order of coefficients.
[[nodiscard]] Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                                            const Distortion& distortion);

/// The picture of the same camera without distortion; `camera` has its size. Depth takes the nearest pixel, because the
/// mean of two depths can be a point without any surface; outside of the picture it is 0.
[[nodiscard]] DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera,
                                   const Distortion& distortion);

/// The same for colour, with bilinear interpolation; outside of the picture it is black.
[[nodiscard]] ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera,
                                    const Distortion& distortion);

}  // namespace scanknit
