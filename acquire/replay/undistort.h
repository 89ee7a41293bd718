// Removes lens distortion once, when a frame is read.
#pragma once

#include <array>
#include <cstdint>

#include "acquire/acquire_config.h"
#include "core/camera.h"
#include "core/image.h"

namespace scanknit {

/// Brown-Conrady distortion over a denominator, OpenCV's order: k1 k2 p1 p2 k3, then k4 k5 k6. Where these three are 0,
/// it is a Distortion.
using RationalDistortion = std::array<double, 8>;

[[nodiscard]] constexpr RationalDistortion rational(const Distortion& d) {
  return {d[0], d[1], d[2], d[3], d[4], 0, 0, 0};
}

/// A fisheye, which ROS calls equidistant: k1 to k4 (J. Kannala and S. S. Brandt 2006, equation (6)). With four zeros
/// the angle to the axis, and not its tangent, is proportional to the distance from the middle.
struct FisheyeDistortion {
  std::array<double, 4> k{};

  friend bool operator==(const FisheyeDistortion&, const FisheyeDistortion&) = default;
};

/// The position of the ideal pixel (u, v) of `camera` in the distorted picture: D. C. Brown 1966 / J. G. Fryer and D.
/// C. Brown 1986; the radial term is divided by 1 + k4 r^2 + k5 r^4 + k6 r^6 (D. Claus and A. W. Fitzgibbon 2005, as
/// OpenCV has it).
[[nodiscard]] Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                                            const RationalDistortion& distortion);
[[nodiscard]] inline Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                                                   const Distortion& distortion) {
  return distort_pixel(u, v, camera, rational(distortion));
}

[[nodiscard]] Eigen::Vector2d distort_pixel(double u, double v, const CameraIntrinsics& camera,
                                            const FisheyeDistortion& distortion);

/// The picture of the same camera without distortion; `camera` has its size. Depth takes the nearest pixel, because the
/// mean of two depths can be a point without any surface; outside of the picture it is 0.
[[nodiscard]] DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera,
                                   const RationalDistortion& distortion);

/// The same for a mask.
[[nodiscard]] Image<std::uint8_t> undistort(const Image<std::uint8_t>& mask, const CameraIntrinsics& camera,
                                            const RationalDistortion& distortion);

/// The same for colour, with bilinear interpolation; outside of the picture it is black.
[[nodiscard]] ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera,
                                    const RationalDistortion& distortion);

[[nodiscard]] DepthImage undistort(const DepthImage& depth_m, const CameraIntrinsics& camera,
                                   const FisheyeDistortion& distortion);
[[nodiscard]] ColourImage undistort(const ColourImage& colour, const CameraIntrinsics& camera,
                                    const FisheyeDistortion& distortion);

/// The same of a picture of any kind, for a lens without a denominator.
template <typename Picture>
[[nodiscard]] Picture undistort(const Picture& picture, const CameraIntrinsics& camera, const Distortion& distortion) {
  return undistort(picture, camera, rational(distortion));
}

}  // namespace scanknit
