// Observation: one frame as integration reads it.
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
#include "fusion/surface_image.h"

namespace scanknit {

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

  [[nodiscard]] const SurfaceImage& surface() const { return surface_; }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Per pixel, the z-range in which the truncation band lies along its ray.
  [[nodiscard]] const DepthPyramid& bands() const { return bands_; }

  [[nodiscard]] bool has_colour() const { return !colours_.empty(); }
  /// The colour camera's picture at a point (sRGB, 0 to 1; the fourth number is 1 in the picture, else 0).
  [[nodiscard]] Eigen::Vector4f colour_at(const Eigen::Vector3f& p_camera) const;

 private:
  void prepare_bands(const FusionConfig& config);
  void prepare_colour(const ColourFrame& colour);

  CameraIntrinsics intrinsics_;
  SurfaceImage surface_;
  DepthPyramid bands_;
  Image<Eigen::Vector4f> colours_;  ///< sRGB, 0 to 1, and 1
  PictureCamera colour_camera_;
  Eigen::Matrix3f R_colour_depth_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t_colour_depth_ = Eigen::Vector3f::Zero();
};

// In the inner loop of integration, hence inline.
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
