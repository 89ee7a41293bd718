// Observation: one depth frame as integration reads it. Every pixel is a small plane.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <optional>
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

/// How much a pixel is believed.
struct PixelTrust {
  float weight = 0;        ///< cos(incidence) / sigma^2(z), 1 for a head-on pixel at the sensor's noise floor
  float truncation_m = 0;  ///< half-width of the band: max(n voxels, k sigma(z))
};

/// What a frame says of one point in space.
struct Sighting {
  float distance_m;    ///< signed distance to the surface, positive on the camera's side; exact within the band
  float truncation_m;  ///< of the pixel that was asked
  float weight;        ///< of the pixel that was asked
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

  [[nodiscard]] float u(const Eigen::Vector3f& p) const { return fx * p.x() / p.z() + cx; }
  [[nodiscard]] float v(const Eigen::Vector3f& p) const { return fy * p.y() / p.z() + cy; }

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
  [[nodiscard]] int nearest() const { return (wx < 0.5f ? 1 : 0) + (wy < 0.5f ? 2 : 0); }
};

class Observation {
 public:
  Observation(const Frame& frame, const FusionConfig& config);

  /// Nothing when the point is not in the picture, or no pixel beside its projection has a return.
  /// The distance is the mean of the distances to the planes of the up to four pixels round the projection, with
  /// bilinear weights: exact on planes even where some of the four are missing. Pixels that show another surface than
  /// the nearest are left out.
  [[nodiscard]] std::optional<Sighting> sight(const Eigen::Vector3f& p_camera) const;

  /// The colour camera's picture at a point (sRGB, 0 to 1), if it is in the picture.
  [[nodiscard]] std::optional<Eigen::Vector3f> colour_at(const Eigen::Vector3f& p_camera) const;

  [[nodiscard]] bool has_colour() const { return colour_ != nullptr; }
  [[nodiscard]] const CameraIntrinsics& intrinsics() const { return intrinsics_; }

  /// Per pixel, the z-range in which the truncation band lies along its ray.
  [[nodiscard]] const DepthPyramid& bands() const { return bands_; }

 private:
  /// sight() for a quad with holes, a jump or at the border.
  [[nodiscard]] std::optional<Sighting> sight_rough(const Eigen::Vector4f& p, const Bilinear& pixels) const;
  [[nodiscard]] bool has_return(int x, int y) const { return planes_.contains(x, y) && planes_.at(x, y).w() != 0; }
  /// The pixel of the four that has a return and the largest share, or -1.
  [[nodiscard]] int nearest_return(const Bilinear& pixels) const;
  [[nodiscard]] bool is_smooth(int x, int y) const;

  CameraIntrinsics intrinsics_;
  PictureCamera camera_;
  Image<PixelPlane> planes_;
  Image<PixelTrust> trust_;
  Image<std::uint8_t> smooth_;  ///< of the four pixels from (x, y): 1 when all have a return and show one surface
  DepthPyramid bands_;
  const ColourFrame* colour_ = nullptr;
  PictureCamera colour_camera_;
  Eigen::Matrix3f R_colour_depth_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t_colour_depth_ = Eigen::Vector3f::Zero();
};

// The inner loop of integration, hence inline.
inline std::optional<Sighting> Observation::sight(const Eigen::Vector3f& p_camera) const {
  if (!(p_camera.z() > 0)) return std::nullopt;
  const float u = camera_.u(p_camera);
  const float v = camera_.v(p_camera);
  if (!camera_.sees(u, v)) return std::nullopt;
  const Bilinear pixels(u, v);
  const Eigen::Vector4f p(p_camera.x(), p_camera.y(), p_camera.z(), -1);
  if (!smooth_.contains(pixels.x, pixels.y) || smooth_.at(pixels.x, pixels.y) == 0) return sight_rough(p, pixels);

  // The mean of four distances to planes is the distance to the mean plane.
  const PixelPlane* plane = &planes_.at(pixels.x, pixels.y);
  const PixelPlane* below = plane + planes_.width();
  const Eigen::Vector4f mean =
      pixels.share(0) * plane[0] + pixels.share(1) * plane[1] + pixels.share(2) * below[0] + pixels.share(3) * below[1];
  const int nearest = pixels.nearest();
  const PixelTrust& trust = trust_.at(pixels.x + (nearest & 1), pixels.y + (nearest >> 1));
  return Sighting{mean.dot(p), trust.truncation_m, trust.weight};
}

}  // namespace scanknit
