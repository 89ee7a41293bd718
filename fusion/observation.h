// Observation: one depth frame as integration reads it. Every pixel is a small plane.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/frame.h"
#include "core/image.h"
#include "fusion/depth_pyramid.h"
#include "fusion/fusion_config.h"

namespace scanknit {

/// The tangent plane of the surface at a pixel, camera frame: (normal, offset_m) with normal . p = offset_m. The normal
/// is unit and points to the camera. All zero: no return.
using PixelPlane = Eigen::Vector4f;

/// A pixel as the inner loop wants it: half a cache line.
struct alignas(32) SurfacePixel {
  PixelPlane plane = PixelPlane::Zero();
  float weight = 0;          ///< cos(incidence) / sigma^2(z), 1 for a head-on pixel at the sensor's noise floor
  float truncation_m = 0;    ///< half-width of the band: max(n voxels, k sigma(z))
  float per_truncation = 0;  ///< 1 / truncation_m
  float same_surface_m = 0;  ///< a neighbour's plane farther off than this shows another surface

  [[nodiscard]] bool has_return() const { return plane.w() != 0; }
};

/// The inner part of the band, where the surface will come to lie whatever the noise: there neighbouring pixels are
/// averaged and colour is taken.
inline constexpr float kInnerBand = 0.5f;

/// What a frame says of one point in space: its signed distance to the plane that it is seen against, and the pixel
/// that was asked. No pixel: the frame says nothing.
struct Sighting {
  float distance_m = 0;
  float offset_m = 0;  ///< of the plane
  const SurfacePixel* pixel = nullptr;
};

/// A pinhole camera in float, as the inner loop wants it.
struct PictureCamera {
  float fx = 0, fy = 0, cx = 0, cy = 0;
  int width = 0, height = 0;

  PictureCamera() = default;
  explicit PictureCamera(const CameraIntrinsics& k)
      : fx(static_cast<float>(k.fx)),
        fy(static_cast<float>(k.fy)),
        cx(static_cast<float>(k.cx)),
        cy(static_cast<float>(k.cy)),
        width(k.width),
        height(k.height) {}

  /// True for coordinates that round to a pixel of the picture; false for NaN.
  [[nodiscard]] bool sees(float u, float v) const {
    return u >= -0.5f && v >= -0.5f && u < static_cast<float>(width) - 0.5f && v < static_cast<float>(height) - 0.5f;
  }
};

/// The four pixels round (u, v) >= -0.5: pixel i is (x + (i & 1), y + (i >> 1)).
struct Bilinear {
  int x, y;
  float wx, wy;  ///< shares of the lower pixel in each direction

  Bilinear(float u, float v)
      : x(static_cast<int>(u + 1.0f) - 1),  // floor, without the library call
        y(static_cast<int>(v + 1.0f) - 1),
        wx(1.0f - (u - static_cast<float>(x))),
        wy(1.0f - (v - static_cast<float>(y))) {}

  [[nodiscard]] float share(int i) const { return ((i & 1) != 0 ? 1.0f - wx : wx) * ((i & 2) != 0 ? 1.0f - wy : wy); }
  /// The pixel with the largest share.
  [[nodiscard]] int nearest() const { return (wx <= 0.5f ? 1 : 0) + (wy <= 0.5f ? 2 : 0); }
};

/// The mean of four rows of numbers, by their shares.
inline Eigen::Vector4f mean_of(const Bilinear& pixels, const Eigen::Vector4f& p00, const Eigen::Vector4f& p10,
                               const Eigen::Vector4f& p01, const Eigen::Vector4f& p11) {
  return pixels.wy * (pixels.wx * p00 + (1 - pixels.wx) * p10) +
         (1 - pixels.wy) * (pixels.wx * p01 + (1 - pixels.wx) * p11);
}

class Observation {
 public:
  Observation(const Frame& frame, const FusionConfig& config);

  [[nodiscard]] const PictureCamera& camera() const { return camera_; }

  /// What the frame says of the point (x, y, z > 0) of the camera frame that projects to (u, v), which the camera sees.
  /// The distance is the mean of the distances to the planes of the up to four pixels round the projection, with
  /// bilinear weights: exact on planes even where some of the four are missing. Pixels that show another surface than
  /// the nearest are left out.
  [[nodiscard]] Sighting sight(float x, float y, float z, float u, float v) const;
  /// The same for any point of the camera frame.
  [[nodiscard]] Sighting sight(const Eigen::Vector3f& p_camera) const;

  /// The colour camera's picture at a point (sRGB, 0 to 1; the fourth number is 1 in the picture, else 0).
  [[nodiscard]] Eigen::Vector4f colour_at(const Eigen::Vector3f& p_camera) const;

  [[nodiscard]] bool has_colour() const { return !colours_.empty(); }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Per pixel, the z-range in which the truncation band lies along its ray.
  [[nodiscard]] const DepthPyramid& bands() const { return bands_; }

 private:
  void prepare_colour(const ColourFrame& colour);
  void prepare_row(const Frame& frame, const FusionConfig& config, int y, Image<DepthRange>& bands);
  [[nodiscard]] bool is_smooth(int x, int y) const;
  [[nodiscard]] bool has_return(int x, int y) const { return pixels_.contains(x, y) && pixels_.at(x, y).has_return(); }
  /// sight() where one of the four pixels is missing or shows another surface.
  [[nodiscard]] Sighting sight_rough(const Eigen::Vector4f& p, const Bilinear& quad) const;

  CameraIntrinsics intrinsics_;
  PictureCamera camera_;
  Image<SurfacePixel> pixels_;
  Image<std::uint8_t> smooth_;  ///< of the four pixels from (x, y): 1 when all have a return and show one surface
  DepthPyramid bands_;
  Image<Eigen::Vector4f> colours_;  ///< sRGB, 0 to 1, and 1
  PictureCamera colour_camera_;
  Eigen::Matrix3f R_colour_depth_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t_colour_depth_ = Eigen::Vector3f::Zero();
};

// The inner loop of integration, hence inline.
[[gnu::always_inline]] inline Sighting Observation::sight(float x, float y, float z, float u, float v) const {
  const Bilinear quad(u, v);
  const int nearest = quad.nearest();
  const SurfacePixel& pixel = pixels_.at(quad.x + (nearest & 1), quad.y + (nearest >> 1));

  // In the outer half of the band a distance counts little (see weight_at): the nearest pixel alone will do.
  const float nearest_m = pixel.plane.x() * x + pixel.plane.y() * y + pixel.plane.z() * z - pixel.plane.w();
  if (pixel.has_return() && std::abs(nearest_m) > kInnerBand * pixel.truncation_m) {
    return {nearest_m, pixel.plane.w(), &pixel};
  }
  if (!smooth_.contains(quad.x, quad.y) || smooth_.at(quad.x, quad.y) == 0)
    return sight_rough(Eigen::Vector4f(x, y, z, -1), quad);

  // The mean of four distances to planes is the distance to the mean plane.
  const SurfacePixel* row = &pixels_.at(quad.x, quad.y);
  const SurfacePixel* below = row + pixels_.width();
  const PixelPlane plane = mean_of(quad, row[0].plane, row[1].plane, below[0].plane, below[1].plane);
  return {plane.x() * x + plane.y() * y + plane.z() * z - plane.w(), plane.w(), &pixel};
}

[[gnu::always_inline]] inline Eigen::Vector4f Observation::colour_at(const Eigen::Vector3f& p_camera) const {
  const Eigen::Vector3f p_colour = R_colour_depth_ * p_camera + t_colour_depth_;
  if (!(p_colour.z() > 0)) return Eigen::Vector4f::Zero();
  const float per_z = 1 / p_colour.z();
  const float u = colour_camera_.fx * p_colour.x() * per_z + colour_camera_.cx;
  const float v = colour_camera_.fy * p_colour.y() * per_z + colour_camera_.cy;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(colours_.width() - 1) &&
        v < static_cast<float>(colours_.height() - 1))) {
    return Eigen::Vector4f::Zero();
  }
  const Bilinear quad(u, v);
  const Eigen::Vector4f* row = &colours_.at(quad.x, quad.y);
  const Eigen::Vector4f* below = row + colours_.width();
  return mean_of(quad, row[0], row[1], below[0], below[1]);
}

}  // namespace scanknit
