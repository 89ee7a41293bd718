// SurfaceImage: the surface that a depth frame shows, one small plane at every pixel.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "core/frame.h"
#include "core/image.h"
#include "core/noise_model.h"

namespace scanknit {

/// A unit normal in 32 bits: x in the low half, y in the high half but for its last bit, which is the sign of z.
/// Wrong by at most 3e-5 in x and y.
using PackedNormal = std::uint32_t;
inline constexpr float kNormalUnit = 1.0f / 32767.0f;

[[nodiscard]] PackedNormal pack(const Eigen::Vector3f& normal);
[[nodiscard]] Eigen::Vector3f unpack(PackedNormal packed);

/// Two pictures rather than one of structs: integration gathers eight pixels at a time from each.
struct SurfaceImage {
  Image<float> z_m;             ///< where the pixel's ray meets its plane; 0: nothing seen
  Image<PackedNormal> normals;  ///< of the plane, towards the camera

  /// The plane at a pixel is that of the frame's normal, or faces the camera where there is none, at the weighted mean
  /// offset of the 3 x 3 pixels round it that show the same surface: noise falls to a third, edges stay. Pixels without
  /// a return between two that show one surface get the plane between them.
  SurfaceImage(const Frame& frame, const NoiseModel& noise);
};

}  // namespace scanknit
